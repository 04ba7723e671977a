#include "vdblic/lic/convolve.h"

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/lic/hits.h"
#include "vdblic/lic/noise.h"

#include <tbb/parallel_for.h>

#include <cstddef>

namespace vdblic {

LeafValues<float> convolve(const Domain& domain, const LeafValues<std::int64_t>& accumulator,
                           const LeafValues<std::int32_t>& input)
{
    LeafValues<float> texture(domain, 0.0f);
    tbb::parallel_for(std::size_t(0), domain.leafCount(), [&](std::size_t leaf) {
        for (int i = 0; i < LeafVoxel::kCount; ++i) {
            const std::int64_t word = accumulator[leaf][i];
            if (word < 0) continue;
            const std::uint64_t sum = Hits::sum(std::uint64_t(word)), count = Hits::count(std::uint64_t(word));
            const float value = count > 0 ? float(double(sum) / double(count)) : float(Input::value(input[leaf][i]));
            texture[leaf][i] = value / float(kNoiseMax);
        }
    });
    return texture;
}

} // namespace vdblic
