#include "vdblic/lic/sharpen.h"

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/lic/neighbourhood.h"

#include <tbb/parallel_for.h>

#include <cstddef>

namespace vdblic {

LeafValues<float> sharpened(const Domain& domain, const LeafValues<float>& texture, float strength)
{
    LeafValues<float> result(domain, 0.0f);
    tbb::parallel_for(std::size_t(0), domain.leafCount(), [&](std::size_t leaf) {
        const NeighbourSums sums = sumNeighbours(domain, texture, leaf, 1);
        const Domain::Mask& mask = domain.mask(leaf);
        for (int i = 0; i < LeafVoxel::kCount; ++i) {
            if (!mask.isOn(openvdb::Index(i))) continue;
            const float centre = texture[leaf][i];
            const float neighbours = sums.weight[std::size_t(i)] - 1;
            const float mean = neighbours > 0 ? (sums.value[std::size_t(i)] - centre) / neighbours : centre;
            result[leaf][i] = centre + strength * (centre - mean);
        }
    });
    return result;
}

} // namespace vdblic
