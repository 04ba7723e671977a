#pragma once

#include "vdblic/field/domain.h"

#include <openvdb/openvdb.h>

#include <cstdint>
#include <utility>

namespace vdblic {

/// The original noise: values 0 to 65535 for every voxel of index space.
///
/// A grid's active voxels give the noise where there are any, their values in [0, 1]; elsewhere the noise is generated
/// from the seed. Immutable; any number of threads may read.
class NoiseField {
  public:
    explicit NoiseField(std::uint32_t seed, openvdb::FloatGrid::ConstPtr grid = nullptr)
        : mSeed(seed), mGrid(std::move(grid))
    {
    }

    /// Fill the 512 values of a leaf, x slowest. @param origin of the leaf
    void fill(const openvdb::Coord& origin, std::int32_t* values) const;

    /// The value that fluid brings which enters the domain in a voxel: noise that is new in every step.
    [[nodiscard]] std::int32_t entering(const openvdb::Coord& voxel, std::uint64_t step) const;
    /// Whether a voxel takes the value of entering fluid in a step: at random, as often as its fluid comes from
    /// outside.
    /// @param stayed the part of the voxel's fluid, 0 to 1, that was inside a step ago
    [[nodiscard]] bool fromOutside(const openvdb::Coord& voxel, std::uint64_t step, float stayed) const;

  private:
    [[nodiscard]] std::int32_t ofStep(const openvdb::Coord& voxel, std::uint64_t number) const;

    std::uint32_t mSeed;
    openvdb::FloatGrid::ConstPtr mGrid;
};

/// Input words of the first step on a domain: the noise, as value and as history. Made in parallel.
[[nodiscard]] LeafValues<std::int32_t> noiseInput(const Domain& domain, const NoiseField& noise);

} // namespace vdblic
