#include "vdblic/render/shown_volume.h"

#include <utility>

namespace vdblic {

ShownVolume::ShownVolume(const PicturePlan& plan, const Look& look, std::shared_ptr<const LoadedTexture> frame,
                         std::shared_ptr<const Solid> solid, Exchange& exchange)
    : mFrame(std::move(frame)), mSolid(std::move(solid))
{
    const std::optional<TextureVolume>& volume = mFrame->volume;
    volume ? (void)mVisible.emplace(*volume, look) : (void)mTree.emplace(*mFrame->tubes, look);
    const bool hasLight = look.shadows > 0 || look.occlusion > 0;
    if (!hasLight && plan.ground == GroundSide::kNone) return;
    volume ? mExtinctions.emplace(*volume, look, exchange) : mExtinctions.emplace(*mTree);
    if (hasLight) mAmbient.emplace(*mExtinctions, mFrame->box(), look, mSolid.get());
}

} // namespace vdblic
