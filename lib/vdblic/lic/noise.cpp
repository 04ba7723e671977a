#include "vdblic/lic/noise.h"

#include "vdblic/field/leaf_voxel.h"

#include <tbb/parallel_for.h>

#include <cstddef>

namespace vdblic {
namespace {

void fillLeaf(const Domain& domain, std::size_t leaf, std::uint32_t seed, float* values)
{
    const openvdb::Coord origin = domain.origin(leaf);
    const Domain::Mask& mask = domain.mask(leaf);
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const LeafVoxel first = LeafVoxel::ofRow(row);
        const std::uint64_t column = noiseColumn(origin.x() + first.x, origin.y() + first.y, seed);
        for (int z = 0; z < LeafVoxel::kDim; ++z) {
            const int offset = LeafVoxel::kDim * row + z;
            if (mask.isOn(openvdb::Index(offset)))
                values[offset] = float(noiseInColumn(column, origin.z() + z)) / float(kNoiseMax);
        }
    }
}

} // namespace

openvdb::FloatGrid::Ptr makeNoise(const Domain& domain, const openvdb::math::Transform& transform, std::uint32_t seed)
{
    const LeafValues<float> values(domain, 0.0f);
    tbb::parallel_for(std::size_t(0), domain.leafCount(),
                      [&](std::size_t leaf) { fillLeaf(domain, leaf, seed, values[leaf]); });
    auto grid = openvdb::FloatGrid::create(values.tree());
    grid->setName("noise");
    grid->setTransform(transform.copy());
    grid->insertMeta("seed", openvdb::Int64Metadata(seed));
    return grid;
}

} // namespace vdblic
