#include "vdblic/run/shared_run.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/flow/frame_halo.h"
#include "vdblic/lic/flow_texture.h"
#include "vdblic/lic/scatter.h"
#include "vdblic/run/advect_params.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <memory>

namespace vdblic {

void SharedRun::checkSame(const std::string& stamp) const
{
    if (mExchange.isAlone()) return;
    const auto number = double(std::hash<std::string>()(stamp) >> 12); // exact
    std::array<double, 2> numbers = {number, -number};
    mExchange.max(numbers);
    if (numbers[0] == -numbers[1]) return;
    throw InputError("the ranks do not see the same frames, or files of different sizes or times: run again when the "
                     "file system shows the sequence to all machines");
}

double SharedRun::largestDisplacement(const LoadedFrame& frame, double interval) const
{
    double largest = frame.velocity.largestDisplacement(interval);
    mExchange.max({&largest, 1});
    return largest;
}

std::optional<std::string> SharedRun::balance(LoadedFrame& frame, FlowTexture& texture)
{
    if (mExchange.isAlone() || texture.steps() == 0) return std::nullopt;
    constexpr double kUnequal = 1.15, kBetter = 0.9;
    const Domain& domain = *frame.flow.velocityDomain();
    const double now = frame.partition->imbalance(domain);
    if (now < kUnequal * mLeastImbalance) return std::nullopt;
    auto partition = std::make_shared<const Partition>(domain, frame.flow.refinement.factors, mExchange.size());
    const double then = partition->imbalance(domain);
    mLeastImbalance = then;
    if (then > kBetter * now) return std::nullopt;
    moveTo(mExchange, frame, partition);
    texture.move(mExchange, *partition, frame.flow.domain);
    return fmt::format("cut anew among the ranks: the largest part had {:.2f} of the mean, now {:.2f}", now, then);
}

void SharedRun::surround(LoadedFrame& start, LoadedFrame& end, double seconds, const FlowTexture& texture)
{
    if (mExchange.isAlone()) return;
    if (end.partition != start.partition) moveTo(mExchange, end, start.partition);
    const auto largest = [&](const LoadedFrame& frame) {
        const openvdb::Mat3d toTexture = frame.flow.refinement.toTexture();
        return largestVelocity(frame.largest, toTexture * frame.velocity.toVoxelsPerStep(seconds));
    };
    const Float4 before = largest(start), after = largest(end);
    const int substeps = mParams.scatter.substeps;
    const std::array<float, 3> slope = texture.largestSlope(seconds / substeps);
    Farthest farthest{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float frame = std::max(before[int(axis)], after[int(axis)]);
        const float step = mParams.steady ? 0.5f * float(mParams.scatter.lifeSpan) * frame : frame / float(substeps);
        const float finer = float(start.flow.refinement.factors[axis]) - 1;
        farthest.path[axis] = longestPath(std::max(step, slope[axis])) + finer;
        farthest.upstream[axis] = frame + 1;
    }
    mDepths = haloDepths(mExchange, *start.partition, farthest);
    vdblic::surround(mExchange, start, mDepths);
    if (&end != &start) vdblic::surround(mExchange, end, mDepths);
}

std::optional<HaloExchange> SharedRun::haloOf(const LoadedFrame& start) const
{
    if (mExchange.isAlone()) return std::nullopt;
    return std::make_optional<HaloExchange>(mExchange, *start.partition, *start.flow.domain, mDepths);
}

std::vector<OwnLeaves> SharedRun::store(const LoadedFrame& frame, TextureFile& file, bool isWriter) const
{
    std::vector<OwnLeaves> stored;
    for (std::size_t i = 0; i < file.computed; ++i) {
        const auto grid = openvdb::gridConstPtrCast<openvdb::FloatGrid>(file.grids[i]);
        const bool isFine = i == 0 || mParams.format.scalars == ScalarVoxels::kTexture;
        const Domain& domain = isFine ? *frame.flow.domain : *frame.flow.velocityDomain();
        stored.push_back(storeOwn(domain, *grid, mParams.format.compression));
        if (isWriter) file.grids[i] = withoutValues(domain, *grid);
    }
    return stored;
}

} // namespace vdblic
