#include "vdblic/render/shown_volume.h"

#include <utility>

namespace vdblic {

ShownVolume::ShownVolume(const PicturePlan& plan, const Look& look, std::shared_ptr<const LoadedTexture> frame,
                         std::shared_ptr<const Solid> solid, Exchange& exchange)
    : mFrame(std::move(frame)), mSolid(std::move(solid)), mVisible(volume(), look)
{
    const bool hasLight = look.shadows > 0 || look.occlusion > 0;
    if (hasLight || plan.ground != GroundSide::kNone) mExtinctions.emplace(volume(), look, exchange);
    if (!hasLight) return;
    mAmbient.emplace(*mExtinctions, volume(), look, mSolid.get());
}

} // namespace vdblic
