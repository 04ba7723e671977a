#include "vdblic/methods/streaks/streaks.h"

#include "vdblic/core/extent.h"
#include "vdblic/methods/memory_estimate.h"
#include "vdblic/methods/method_params.h"
#include "vdblic/methods/streaks/streak_shape.h"
#include "vdblic/methods/streaks/streak_texture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>

namespace vdblic {
namespace {

constexpr int kStreakSettling = 2; // frames: streaks begin with whole tails; then the controller thins them

int tailAndSettling(const MethodParams& params)
{
    constexpr float kUnknownTail = 4;
    return int(std::ceil(params.streaks.tail.value_or(kUnknownTail) + kStreakSettling));
}

double streakBytes(const MethodParams& params, const FrameDomain& first, const Refinement& given, bool /*withHits*/)
{
    openvdb::CoordBBox box;
    (void)first.velocity->topology().evalActiveVoxelBoundingBox(box);
    const StreakShape shape = streakShape(params.streaks, given, *first.velocity, 0);
    const auto leaves = double(first.velocity->local().size());
    return streakCost(shape, params.streaks.draw, double(first.velocity->voxelCount()), leaves, box).bytes;
}

} // namespace

constinit const TextureMethod kStreaks{
    .name = "streaks",
    .text = "sparse, with a head and a tail",
    .isSparse = true,
    .preroll = [](const MethodParams& /*params*/) { return kStreakSettling; },
    .leadIn = tailAndSettling,
    .make = [](const MethodParams& params, MethodInput&& input) -> std::unique_ptr<FlowTexture> {
        return std::make_unique<StreakTexture>(params.texture, params.streaks, input.refinement, input.seed);
    },
    .describe = [](const MethodParams& /*params*/, openvdb::MetaMap& /*metadata*/) {}, // each texture has its shape
    .bytes = streakBytes,
};

StreakCost streakCost(const StreakShape& shape, StreakForm form, double voxels, double leaves,
                      const openvdb::CoordBBox& box)
{
    constexpr double kDrawn = 90, kSeconds = 1.86e-7;   // for the square of the texture voxels in a spacing, a streak
    constexpr double kLine = 1600, kLineSeconds = 4e-6; // a streak
    double cells = voxels, inCell = 1;
    for (std::size_t axis = 0; voxels > 0 && axis < 3; ++axis) {
        const double spacing = std::min(double(shape.spacing[axis]), double(extentOf(box)[axis]));
        cells /= spacing;
        inCell *= spacing * shape.refinement.factors[axis];
    }
    const double before = kProcessBytes + (kVelocityBytes * Domain::kLeafVoxels + kVelocityBrickBytes) * leaves;
    if (form == StreakForm::kLines) return {cells, before + kLine * cells, kLineSeconds * cells};
    const double drawn = cells * std::pow(inCell, 2.0 / 3);
    return {cells, before + kDrawn * drawn, kSeconds * drawn};
}

} // namespace vdblic
