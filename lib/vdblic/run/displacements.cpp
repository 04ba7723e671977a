#include "vdblic/run/displacements.h"

#include "vdblic/core/exchange.h"
#include "vdblic/core/paging.h"
#include "vdblic/flow/velocity_frame.h"

#include <openvdb/openvdb.h>
#include <openvdb/tree/LeafManager.h>

#include <tbb/parallel_reduce.h>

#include <bit>
#include <cmath>

namespace vdblic {

void Displacements::add(const VelocityFrame& frame, double interval)
{
    const openvdb::Mat3s toFrame(frame.toVoxelsPerFrame(interval).matrix);
    const auto count = [&](const openvdb::Vec3s& value, std::uint64_t voxels, Counts& counts) {
        const float squared = (toFrame * value).lengthSqr();
        if (std::isfinite(squared)) counts[std::bit_cast<std::uint32_t>(squared) >> kDroppedBits] += voxels;
    };
    const auto added = [](Counts sums, const Counts& more) {
        for (std::size_t i = 0; i < kSteps; ++i)
            sums[i] += more[i];
        return sums;
    };
    const openvdb::Vec3STree& tree = frame.values->tree();
    const openvdb::tree::LeafManager<const openvdb::Vec3STree> leaves(tree);
    constexpr std::size_t kGrain = 256; // leaves: far more work than merging counts
    mCounts = added(mCounts, tbb::parallel_reduce(
                                 leaves.leafRange(kGrain), Counts(kSteps),
                                 [&](const auto& range, Counts counts) {
                                     for (auto leaf = range.begin(); leaf; ++leaf) {
                                         paging::breathe(paging::kLeafBytes);
                                         for (auto value = leaf->cbeginValueOn(); value; ++value)
                                             count(*value, 1, counts);
                                     }
                                     return counts;
                                 },
                                 added));
    auto tile = tree.cbeginValueOn();
    tile.setMaxDepth(tile.getLeafDepth() - 1);
    for (; tile; ++tile)
        count(*tile, tile.getVoxelCount(), mCounts);
}

void Displacements::join(Exchange& exchange)
{
    exchange.sum(mCounts);
}

double Displacements::ofFasterHalf() const
{
    const auto lengthOf = [](std::size_t step) {
        const auto middle = std::bit_cast<float>(std::uint32_t(step << kDroppedBits | 1u << (kDroppedBits - 1)));
        return step == 0 ? 0.0 : std::sqrt(double(middle));
    };
    double all = 0;
    for (std::size_t i = 0; i < kSteps; ++i)
        all += lengthOf(i) * double(mCounts[i]);
    double faster = 0;
    for (std::size_t i = kSteps; i-- > 1;) {
        faster += lengthOf(i) * double(mCounts[i]);
        if (faster > 0 && faster >= all / 2) return lengthOf(i);
    }
    return 0;
}

} // namespace vdblic
