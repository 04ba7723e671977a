#include "vdblic/render/shown_volume.h"

#include "vdblic/cast/earth_map.h"

#include <utility>

namespace vdblic {

std::shared_ptr<const Solid> shownSolid(const PicturePlan& plan, const openvdb::FloatGrid& domain, std::int64_t frame)
{
    Solid solid = makeSolid(plan.solid, domain, plan.stretch, frame);
    if (plan.earth) solid.earth = std::make_shared<const EarthMap>();
    return std::make_shared<const Solid>(std::move(solid));
}

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
