#include "vdblic/lic/noise.h"

#include <tbb/parallel_for.h>

namespace vdblic {
namespace {

void fillLeaf(const Domain& domain, std::size_t leaf, std::uint32_t seed, float* values)
{
    const openvdb::Coord origin = domain.origin(leaf);
    const Domain::Mask& mask = domain.mask(leaf);
    int offset = 0;
    for (int x = 0; x < LeafVoxel::kDim; ++x) {
        for (int y = 0; y < LeafVoxel::kDim; ++y) {
            const std::uint64_t column = noiseColumn(origin.x() + x, origin.y() + y, seed);
            for (int z = 0; z < LeafVoxel::kDim; ++z, ++offset) {
                if (mask.isOn(offset)) values[offset] = float(noiseInColumn(column, origin.z() + z)) / float(kNoiseMax);
            }
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
