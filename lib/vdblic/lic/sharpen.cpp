#include "vdblic/lic/sharpen.h"

#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"
#include "vdblic/lic/neighbourhood.h"

#include <cstddef>
#include <cstdint>

namespace vdblic {
namespace {

VDBLIC_KERNEL void sharpenLeaf(const NeighbourSums& sums, const Domain::Mask& mask, const float* texture,
                               float strength, const ValueRange& range, float* result)
{
    const auto load = [](const float* from) {
        Float8 values;
        __builtin_memcpy(&values, from, sizeof values);
        return values;
    };
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const auto first = std::size_t(row) * LeafVoxel::kDim;
        const Float8 centre = load(texture + first), neighbours = load(&sums.weight[first]) - 1;
        const Float8 mean = neighbours > 0 ? (load(&sums.value[first]) - centre) / neighbours : centre;
        Float8 value = centre + strength * (centre - mean);
        value = value < range.least ? broadcast8(range.least) : value;
        value = value > range.most ? broadcast8(range.most) : value;
        value = maskOf(mask.getWord<std::uint8_t>(openvdb::Index(row))) ? value : Float8{};
        __builtin_memcpy(result + first, &value, sizeof value);
    }
}

} // namespace

LeafValues<float> sharpened(const Domain& domain, const LeafValues<float>& texture, float strength,
                            const ValueRange& range)
{
    LeafValues<float> result(domain, 0.0f);
    forLeaves(domain.local(), [&](std::size_t leaf) {
        const NeighbourSums sums = sumNeighbours(domain, texture, leaf, 1);
        sharpenLeaf(sums, domain.mask(leaf), texture[leaf], strength, range, result[leaf]);
    });
    return result;
}

} // namespace vdblic
