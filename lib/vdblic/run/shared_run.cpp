#include "vdblic/run/shared_run.h"

#include "vdblic/core/errors.h"
#include "vdblic/distributed/halo_exchange.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/flow/frame_halo.h"
#include "vdblic/methods/flow_texture.h"
#include "vdblic/run/advect_plan.h"
#include "vdblic/run/displacements.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <iterator>
#include <memory>
#include <utility>

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

double SharedRun::largestDisplacement(const VelocityFrame& frame, double interval) const
{
    double largest = frame.largestDisplacement(interval);
    mExchange.max({&largest, 1});
    return largest;
}

double SharedRun::fasterDisplacement(const VelocityFrame& frame, double interval) const
{
    Displacements displacements;
    displacements.add(frame, interval);
    displacements.join(mExchange);
    return displacements.ofFasterHalf();
}

std::optional<std::string> SharedRun::balance(VelocityFrame& frame, FlowTexture& texture)
{
    if (mExchange.isAlone()) return std::nullopt;
    constexpr double kUnequal = 1.15, kBetter = 0.9;
    const Domain& domain = *frame.domain.velocity;
    const double now = frame.partition->imbalance(domain);
    if (now < kUnequal * mLeastImbalance) return std::nullopt;
    auto partition = std::make_shared<const Partition>(domain, frame.domain.refinement.factors, mExchange.size());
    const double then = partition->imbalance(domain);
    mLeastImbalance = then;
    if (then > kBetter * now) return std::nullopt;
    const std::shared_ptr<const Domain> before = frame.domain.texture;
    handOver(mExchange, frame, partition);
    const Domain::Leaves had = before->own(), has = frame.domain.texture->own();
    std::vector<std::uint32_t> either;
    std::set_union(had.begin(), had.end(), has.begin(), has.end(), std::back_inserter(either));
    const auto both = before->ofRank({has.begin(), has.end()}, std::move(either));
    const std::vector<Rim<Space::kTexture>> noHalo(std::size_t(mExchange.size()));
    if (auto* const state = dynamic_cast<LeafState*>(&texture))
        state->handOver(HaloExchange(mExchange, *partition, *both, noHalo), both);
    return fmt::format("cut anew among the ranks: the largest part had {:.2f} of the mean, now {:.2f}", now, then);
}

void SharedRun::surround(VelocityFrame& start, VelocityFrame& end, double seconds, const FlowTexture& texture)
{
    if (mExchange.isAlone()) return;
    if (end.partition != start.partition) handOver(mExchange, end, start.partition);
    const auto largest = [&](const VelocityFrame& frame) {
        return largestSpeeds(frame.largest, frame.domain.refinement.toTexture(frame.toVoxelsPerFrame(seconds)));
    };
    const Speeds<Space::kTexture, Per::kFrame> fastest = larger(largest(start), largest(end));
    Farthest farthest{texture.farthestPath(fastest, seconds / mPlan.substeps()), {}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        farthest.path.along[axis] += float(start.domain.refinement.factors[axis]) - 1;
        farthest.upstream.along[axis] = fastest[axis] + 1;
    }
    mDepths = haloDepths(mExchange, *start.partition, farthest, start.domain.texture->period());
    vdblic::surround(mExchange, start, mDepths);
    if (&end != &start) vdblic::surround(mExchange, end, mDepths);
}

std::unique_ptr<const LeafOwners> SharedRun::ownersOf(const VelocityFrame& start) const
{
    if (mExchange.isAlone()) return std::make_unique<const SoleOwner>();
    return std::make_unique<const HaloExchange>(mExchange, *start.partition, *start.domain.texture, mDepths);
}

std::vector<OwnLeaves> SharedRun::store(const VelocityFrame& frame, TextureFile& file, bool isWriter) const
{
    std::vector<OwnLeaves> stored;
    for (std::size_t i = 0; i < file.computed; ++i) {
        const Domain& domain = i < file.onTexture ? *file.domain : *frame.domain.velocity;
        stored.push_back(storeOwn(domain, *file.grids[i], mPlan.params.format.compression));
        if (isWriter) file.grids[i] = withoutValues(domain, *file.grids[i]);
    }
    return stored;
}

} // namespace vdblic
