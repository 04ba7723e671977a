#include "vdblic/coherence/smoothed_texture.h"

#include "vdblic/core/paging.h"
#include "vdblic/lic/neighbourhood.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <cstddef>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

LeafValues<float> valuesOf(const openvdb::FloatTree& texture, const Domain& domain)
{
    LeafValues<float> values(domain, 0.0f);
    tbb::parallel_for(std::size_t(0), domain.leafCount(), [&](std::size_t leaf) {
        paging::breathe(paging::kLeafBytes);
        const auto* source = texture.probeConstLeaf(domain.origin(leaf));
        const float tile = source ? 0 : texture.getValue(domain.origin(leaf));
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel)
            values[leaf][voxel.pos()] = source ? source->getValue(voxel.pos()) : tile;
    });
    return values;
}

LeafValues<float> smoothed(const Domain& domain, const LeafValues<float>& values)
{
    LeafValues<float> result(domain, 0.0f);
    tbb::parallel_for(std::size_t(0), domain.leafCount(), [&](std::size_t leaf) {
        paging::breathe(paging::kLeafBytes);
        const NeighbourSums sums = sumNeighbours(domain, values, leaf, 2);
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel)
            result[leaf][voxel.pos()] = sums.value[voxel.pos()] / sums.weight[voxel.pos()];
    });
    return result;
}

Contrast contrastOf(const Domain& domain, const LeafValues<float>& values)
{
    struct Sums {
        double sum = 0, squares = 0;
        std::size_t saturated = 0;
    };
    std::vector<Sums> sums(domain.leafCount());
    tbb::parallel_for(std::size_t(0), domain.leafCount(), [&](std::size_t leaf) {
        paging::breathe(paging::kLeafBytes);
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel) {
            const double value = double(values[leaf][voxel.pos()]) - 0.5;
            sums[leaf].sum += value;
            sums[leaf].squares += value * value;
            constexpr double kSaturated = 0.5 - 0.5 / 255; // beyond: rounds to 0 or 255 of eight bits
            sums[leaf].saturated += std::abs(value) > kSaturated;
        }
    });
    Sums all;
    for (const Sums& leaf : sums) { // in order: the same result for any number of threads
        all.sum += leaf.sum;
        all.squares += leaf.squares;
        all.saturated += leaf.saturated;
    }
    const double count = double(domain.voxelCount()), mean = all.sum / count;
    const double variance = all.squares / count - mean * mean;
    return {std::sqrt(variance < 0 ? 0 : variance), double(all.saturated) / count};
}

} // namespace

SmoothedTexture::SmoothedTexture(const openvdb::FloatTree& texture)
{
    auto topology = std::make_shared<openvdb::MaskTree>(texture, false, true, openvdb::TopologyCopy());
    const auto domain = std::make_shared<const Domain>(std::move(topology));
    const LeafValues<float> raw = valuesOf(texture, *domain), smooth = smoothed(*domain, raw);
    mRawContrast = contrastOf(*domain, raw);
    mSmoothedContrast = contrastOf(*domain, smooth);
    mBricks.cover(domain);
    std::vector<std::size_t> all(domain->leafCount());
    std::iota(all.begin(), all.end(), std::size_t(0));
    mBricks.fill(all, [&](std::size_t leaf, Values::Record* records) {
        visitBrick(*raw.tree(), domain->origin(leaf), [&](int record, float value, bool active) {
            records[record] = {};
            if (!active) return;
            records[record].values[kRaw] = value;
            records[record].values[kCoverage] = 1;
        });
        visitBrick(*smooth.tree(), domain->origin(leaf), [&](int record, float value, bool active) {
            if (active) records[record].values[kSmoothed] = value;
        });
    });
}

} // namespace vdblic
