#include "vdblic/lic/sharpen.h"

#include "vdblic/field/domain_rows.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"
#include "vdblic/lic/neighbourhood.h"

#include <cstddef>

namespace vdblic {
namespace {

VDBLIC_KERNEL void sharpenLeaf(const NeighbourSums& sums, const Domain::Mask& mask, const float* texture,
                               float strength, const ValueRange& range, float* result)
{
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const Float8 centre = loadRow(texture, row), neighbours = loadRow(sums.weight.data(), row) - 1;
        const Float8 mean = neighbours > 0 ? (loadRow(sums.value.data(), row) - centre) / neighbours : centre;
        Float8 value = centre + strength * (centre - mean);
        value = value < range.least ? broadcast8(range.least) : value;
        value = value > range.most ? broadcast8(range.most) : value;
        storeRow(activeRow(mask, row) ? value : Float8{}, result, row);
    }
}

} // namespace

void sharpen(const Domain& domain, const LeafValues<float>& texture, std::size_t leaf, float strength,
             const ValueRange& range, float* result)
{
    const NeighbourSums sums = sumNeighbours(domain, texture, leaf, 1);
    sharpenLeaf(sums, domain.mask(leaf), texture[leaf], strength, range, result);
}

LeafValues<float> sharpened(const Domain& domain, const LeafValues<float>& texture, float strength,
                            const ValueRange& range)
{
    LeafValues<float> result(domain, 0.0f);
    forLeaves(domain.local(), [&](std::size_t leaf) { sharpen(domain, texture, leaf, strength, range, result[leaf]); });
    return result;
}

} // namespace vdblic
