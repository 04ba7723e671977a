#include "vdblic/render/shown_volume.h"

#include "vdblic/camera/clipping.h"

#include <utility>
#include <vector>

namespace vdblic {

ShownVolume::ShownVolume(const PicturePlan& plan, const Look& look, std::shared_ptr<const LoadedTexture> frame,
                         std::shared_ptr<const Solid> solid, Exchange& exchange)
    : mFrame(std::move(frame)), mSolid(std::move(solid)), mVisible(volume(), look)
{
    const bool hasLight = look.shadows > 0 || look.occlusion > 0;
    if (hasLight || plan.ground.side != GroundSide::kNone) mExtinctions.emplace(volume(), look, exchange);
    if (!hasLight) return;
    const std::vector<ClipPlane> solidCuts = plan.rays.clip.stretched(plan.stretch).solidPlanes();
    mAmbient.emplace(*mExtinctions, volume(), look, mSolid.get(), solidCuts);
}

} // namespace vdblic
