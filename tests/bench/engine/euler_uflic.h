#pragma once

#include "vdblic/lic/pathline.h"
#include "vdblic/methods/auflic/accumulator.h"
#include "vdblic/noise/noise_field.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace vdblic::bench {

/// UFLIC as Shen & Kao 1998 and Table 1 of Liu & Moorhead 2004 describe it: a seed from every voxel's centre, Euler
/// steps clamped to the faces of voxels, values weighted by the length of the path through each voxel, one scattering
/// process after the other into a ring of buckets. On one thread.
class EulerUflic {
  public:
    EulerUflic(int lifeSpan, NoiseField noise) : mLifeSpan(std::size_t(lifeSpan)), mNoise(std::move(noise)) {}

    /// @param fields the velocity over each step, as many as the life span beyond k
    LeafValues<float> scatteringProcess(std::size_t k, std::vector<VelocityField>& fields);

  private:
    void scatterSeed(std::size_t k, const std::vector<VelocityField>& fields, Float4 position, std::uint64_t value);

    std::size_t mLifeSpan;
    NoiseField mNoise;
    std::vector<Accumulator> mBuckets;
    LeafValues<std::int32_t> mInput;
};

} // namespace vdblic::bench
