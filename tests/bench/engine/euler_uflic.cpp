#include "bench/engine/euler_uflic.h"

#include "vdblic/lic/hits.h"
#include "vdblic/methods/auflic/convolve.h"
#include "vdblic/methods/auflic/feedback.h"

#include <algorithm>
#include <cmath>

namespace vdblic::bench {

void EulerUflic::scatterSeed(std::size_t k, const std::vector<VelocityField>& fields, Float4 position,
                             std::uint64_t value)
{
    constexpr float kLeast = 1e-3f;    // of a step: gets a particle over the face it was clamped to
    constexpr float kLengthUnits = 16; // weights are sixteenths of a voxel
    constexpr int kMostSteps = 400;
    float time = 0;
    for (int steps = 0; time < float(mLifeSpan) - kLeast && steps < kMostSteps; ++steps) {
        const auto s = std::size_t(time);
        const VelocityField& field = fields[k + s];
        const Int4 voxel = voxelOf(position);
        const int leaf = field.domain().findLeaf(voxel);
        if (leaf < 0 || !field.domain().isActive(leaf, Domain::offset(voxel))) return;
        const Float4 velocity = field.sample(position, time - float(s), Float4{});
        float duration = float(s + 1) - time;
        for (int axis = 0; axis < 3; ++axis) {
            const float face = float(voxel[axis]) + (velocity[axis] > 0 ? 0.5f : -0.5f);
            if (std::abs(velocity[axis]) > 1e-6f)
                duration = std::min(duration, (face - position[axis]) / velocity[axis] + kLeast);
        }
        duration = std::max(duration, kLeast);
        const float length = duration * pathline::length(velocity);
        const auto weight = std::uint64_t(std::max(1, int(std::floor(length * kLengthUnits + 0.5f))));
        mBuckets[(k + s) % mLifeSpan][std::size_t(leaf)][Domain::offset(voxel)] +=
            std::int64_t(weight * Hits::pack(value, 1));
        position += velocity * duration;
        time += duration;
        if (float(s + 1) - time < 1e-4f) time = float(s + 1);
    }
}

LeafValues<float> EulerUflic::scatteringProcess(std::size_t k, std::vector<VelocityField>& fields)
{
    const Domain& domain = fields[k].domain();
    if (mBuckets.empty()) {
        mInput = noiseInput(domain, mNoise);
        for (std::size_t i = 0; i < mLifeSpan; ++i)
            mBuckets.emplace_back(domain).open(domain.own());
    }
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf) {
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel) {
            const openvdb::Coord at = domain.origin(leaf) + Domain::Leaf::offsetToLocalCoord(voxel.pos());
            scatterSeed(k, fields, Float4{float(at[0]), float(at[1]), float(at[2]), 0},
                        std::uint32_t(mInput[leaf][voxel.pos()]));
        }
    }
    Accumulator& bucket = mBuckets[k % mLifeSpan];
    LeafValues<float> texture(domain, 0.0f);
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf)
        convolve(domain.mask(leaf), bucket[leaf], mInput[leaf], texture[leaf]);
    bucket.open(domain.own());
    mInput = feedForward(fields[k], texture, domain, mNoise, FeedbackParams{}, k);
    return texture;
}

} // namespace vdblic::bench
