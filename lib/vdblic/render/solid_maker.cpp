#include "vdblic/render/solid_maker.h"

#include "vdblic/cast/earth_map.h"
#include "vdblic/render/loaded_texture.h"
#include "vdblic/render/render_plan.h"

#include <utility>

namespace vdblic {

std::shared_ptr<const Solid> SolidMaker::of(const PicturePlan& plan, const LoadedTexture& frame)
{
    if (plan.solid.empty()) return nullptr;
    Key key{plan.solid, plan.earth, plan.stretch, std::nullopt, frame.texture ? frame.texture->voxelSize()[0] : 0};
    if (solidChanges(plan.solid)) key.frame = frame.file.frame;
    {
        const std::lock_guard lock(mMutex);
        if (mSolid && mKey == key) return mSolid;
    }
    Solid made = makeSolid(plan.solid, *frame.domain(), plan.stretch, frame.file.frame);
    if (plan.earth) made.earth = std::make_shared<const EarthMap>();
    const std::lock_guard lock(mMutex);
    mKey = std::move(key);
    mSolid = std::make_shared<const Solid>(std::move(made));
    return mSolid;
}

} // namespace vdblic
