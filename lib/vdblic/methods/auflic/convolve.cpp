#include "vdblic/methods/auflic/convolve.h"

#include "vdblic/field/domain_rows.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"
#include "vdblic/lic/hits.h"
#include "vdblic/noise/noise.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace vdblic {
namespace {

/// Hit counts of a row's voxels, and means of their values: NaN without hits.
struct HitRow {
    Float8 count, mean;
};
VDBLIC_INLINE HitRow hitRow(const std::int64_t* hits, int row)
{
    Float4 count[2], mean[2];
    for (int half = 0; half < 2; ++half) {
        UnsignedLong4 words;
        __builtin_memcpy(&words, hits + row * std::ptrdiff_t(LeafVoxel::kDim) + std::ptrdiff_t(4) * half, sizeof words);
        const Double4 sums = toDoubles(words >> Hits::kCountBits), counts = toDoubles(words & Hits::kCountMask);
        count[half] = __builtin_convertvector(counts, Float4);
        mean[half] = __builtin_convertvector(sums / counts, Float4);
    }
    return {__builtin_shufflevector(count[0], count[1], 0, 1, 2, 3, 4, 5, 6, 7),
            __builtin_shufflevector(mean[0], mean[1], 0, 1, 2, 3, 4, 5, 6, 7)};
}

/// Values on a domain's own leaves, with room for its other local ones; for a single process, the values themselves.
LeafValues<float> onLocal(const Domain& domain, const LeafValues<float>& own)
{
    if (domain.isWhole()) return own;
    LeafValues<float> local(domain, 0.0f);
    forLeaves(domain.own(), [&](std::size_t leaf) { std::copy_n(own[leaf], LeafVoxel::kCount, local[leaf]); });
    return local;
}

/// The running mean on another domain: a new voxel has its input, with weight 0.
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

} // namespace

VDBLIC_KERNEL void convolve(const Domain::Mask& mask, const std::int64_t* hits, const std::int32_t* input,
                            float* texture)
{
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const HitRow of = hitRow(hits, row);
        const Float8 value = of.count > 0 ? of.mean : __builtin_convertvector(loadRow(input, row), Float8);
        storeRow(activeRow(mask, row) ? value / float(kNoiseMax) : Float8{}, texture, row);
    }
}

VDBLIC_KERNEL void convolve(const Domain::Mask& mask, const std::int64_t* hits, const std::int32_t* input, int substeps,
                            const MeanLeaf<const float>& before, const MeanLeaf<float>& after)
{
    const float kept = float(substeps - 1) / float(substeps + 1); // share of the older hits' weight
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const HitRow of = hitRow(hits, row);
        const Float8 older = before.weight ? loadRow(before.weight, row) * kept : Float8{};
        const Float8 weight = older + of.count;
        const Float8 mean = before.mean ? loadRow(before.mean, row)
                                        : __builtin_convertvector(loadRow(input, row), Float8) / float(kNoiseMax);
        const Float8 moved = mean + (of.mean / float(kNoiseMax) - mean) * (of.count / weight);
        const Int8 on = activeRow(mask, row);
        storeRow(on ? of.count > 0 ? moved : mean : Float8{}, after.mean, row);
        storeRow(on ? weight : Float8{}, after.weight, row);
    }
}

Convolution::Convolution(const Domain& domain, const LeafValues<std::int32_t>& input, int substeps,
                         std::optional<RunningMean> before)
    : mDomain(domain), mInput(input), mSubsteps(substeps), mBefore(std::move(before))
{
    if (substeps > 1) {
        mAfter = {{domain, 0.0f, domain.own()}, {domain, 0.0f, domain.own()}};
    } else {
        mTexture = LeafValues<float>(domain, 0.0f);
    }
}

void Convolution::take(std::size_t leaf, const std::int64_t* hits)
{
    if (mAfter) {
        const auto before = mBefore ? std::as_const(*mBefore).of(leaf) : MeanLeaf<const float>{};
        convolve(mDomain.mask(leaf), hits, mInput[leaf], mSubsteps, before, mAfter->of(leaf));
    } else {
        convolve(mDomain.mask(leaf), hits, mInput[leaf], mTexture[leaf]);
    }
}

LeafValues<float> Convolution::texture()
{
    mBefore.reset();
    return mAfter ? onLocal(mDomain, mAfter->mean) : std::move(mTexture);
}

std::optional<RunningMean> Convolution::meanOn(const Domain& next, const LeafValues<std::int32_t>& input)
{
    if (!mAfter || &next == &mDomain) return std::move(mAfter);
    return onDomain(next, input, mDomain, *mAfter);
}

} // namespace vdblic
