#include "vdblic/render/shown_volume.h"

#include <utility>

namespace vdblic {

ShownVolume::ShownVolume(const PicturePlan& plan, const Look& look, std::shared_ptr<const LoadedTexture> frame,
                         std::shared_ptr<const Solid> solid, Exchange& exchange, const Look* linesLook)
    : mFrame(std::move(frame)), mSolid(std::move(solid))
{
    const std::optional<TextureVolume>& volume = mFrame->volume;
    volume ? (void)mVisible.emplace(*volume, look) : (void)mTree.emplace(*mFrame->tubes, look);
    if (linesLook && mFrame->lines) mTree.emplace(*mFrame->lines->tubes, *linesLook);
    const bool hasLight = look.shadows > 0 || look.occlusion > 0;
    if (!hasLight && plan.ground == GroundSide::kNone) return;
    volume ? mExtinctions.emplace(*volume, look, exchange, tree()) : mExtinctions.emplace(*mTree);
    if (hasLight) mAmbient.emplace(*mExtinctions, mFrame->box(), look, mSolid.get());
}

} // namespace vdblic
