#include "vdblic/lic/convolve.h"

#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/lic/hits.h"
#include "vdblic/lic/noise.h"

#include <algorithm>
#include <cstddef>

namespace vdblic {

LeafValues<float> convolve(const Domain& domain, const LeafValues<std::int64_t>& accumulator,
                           const LeafValues<std::int32_t>& input)
{
    LeafValues<float> texture(domain, 0.0f);
    forLeaves(domain.own(), [&](std::size_t leaf) {
        for (int i = 0; i < LeafVoxel::kCount; ++i) {
            const std::int64_t word = accumulator[leaf][i];
            if (word < 0) continue;
            const std::uint64_t sum = Hits::sum(std::uint64_t(word)), count = Hits::count(std::uint64_t(word));
            const float value = count > 0 ? float(double(sum) / double(count)) : float(input[leaf][i]);
            texture[leaf][i] = value / float(kNoiseMax);
        }
    });
    return texture;
}

RunningMean convolve(const Domain& domain, const LeafValues<std::int64_t>& accumulator,
                     const LeafValues<std::int32_t>& input, const RunningMean* before, int substeps)
{
    const float kept = float(substeps - 1) / float(substeps + 1); // of the older hits' weight
    RunningMean result{LeafValues<float>(domain, 0.0f, domain.own()), LeafValues<float>(domain, 0.0f, domain.own())};
    forLeaves(domain.own(), [&](std::size_t leaf) {
        for (int i = 0; i < LeafVoxel::kCount; ++i) {
            const std::int64_t word = accumulator[leaf][i];
            if (word < 0) continue;
            const std::uint64_t sum = Hits::sum(std::uint64_t(word)), count = Hits::count(std::uint64_t(word));
            const float older = before ? before->weight[leaf][i] * kept : 0, weight = older + float(count);
            float mean = before ? before->mean[leaf][i] : float(input[leaf][i]) / float(kNoiseMax);
            if (count > 0) {
                const float hit = float(double(sum) / double(count)) / float(kNoiseMax);
                mean += (hit - mean) * (float(count) / weight);
            }
            result.mean[leaf][i] = mean;
            result.weight[leaf][i] = weight;
        }
    });
    return result;
}

LeafValues<float> onLocal(const Domain& domain, const LeafValues<float>& own)
{
    if (domain.isWhole()) return own;
    LeafValues<float> local(domain, 0.0f);
    forLeaves(domain.own(), [&](std::size_t leaf) { std::copy_n(own[leaf], LeafVoxel::kCount, local[leaf]); });
    return local;
}

RunningMean onDomain(const Domain& to, const LeafValues<std::int32_t>& input, const Domain& from,
                     const RunningMean& mean)
{
    RunningMean result{LeafValues<float>(to, 0.0f, to.own()), LeafValues<float>(to, 0.0f, to.own())};
    forLeaves(to.own(), [&](std::size_t leaf) {
        const openvdb::Coord origin = to.origin(leaf);
        const int there = from.findLeaf(Int4{origin[0], origin[1], origin[2], 0});
        for (auto voxel = to.mask(leaf).beginOn(); voxel; ++voxel) {
            const auto i = voxel.pos();
            const bool isOld = there >= 0 && from.isActive(there, i);
            result.mean[leaf][i] = isOld ? mean.mean[std::size_t(there)][i] : float(input[leaf][i]) / float(kNoiseMax);
            if (isOld) result.weight[leaf][i] = mean.weight[std::size_t(there)][i];
        }
    });
    return result;
}

} // namespace vdblic
