#include "vdblic/noise/noise.h"

#include "vdblic/field/domain_rows.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"

#include <cstddef>

namespace vdblic {
namespace {

VDBLIC_KERNEL void fillLeaf(const openvdb::Coord& origin, const Domain::Mask& mask, std::uint32_t seed, float* values)
{
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const LeafVoxel first = LeafVoxel::ofRow(row);
        const std::uint64_t column = noiseColumn(origin.x() + first.x, origin.y() + first.y, seed);
        const Float8 noise = __builtin_convertvector(noiseRow(column, origin.z()), Float8) / float(kNoiseMax);
        storeRow(activeRow(mask, row) ? noise : Float8{}, values, row);
    }
}

} // namespace

openvdb::FloatGrid::Ptr makeNoise(const Domain& domain, const openvdb::math::Transform& transform, std::uint32_t seed)
{
    LeafValues<float> values(domain, 0.0f);
    forLeaves(domain.own(),
              [&](std::size_t leaf) { fillLeaf(domain.origin(leaf), domain.mask(leaf), seed, values[leaf]); });
    auto grid = openvdb::FloatGrid::create(values.tree());
    grid->setName("noise");
    grid->setTransform(transform.copy());
    grid->insertMeta("seed", openvdb::Int64Metadata(seed));
    return grid;
}

} // namespace vdblic
