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
    /// The value of a single voxel.
    [[nodiscard]] std::int32_t at(const openvdb::Coord& voxel) const;
    /// The values at the corners of a cube, z the fastest. @param first corner  @param edge of the cube [voxels]
    /// @param values receives eight
    void atCorners(const openvdb::Coord& first, int edge, std::int32_t* values) const;

    /// White noise that changes in every step, by voxel and step number.
    [[nodiscard]] std::int32_t ofStep(const openvdb::Coord& voxel, std::uint64_t number) const;

    /// The noise of fluid that entered the domain through a voxel: white noise in time, averaged over `span` frames
    /// around the time of entry, as noise upstream would be along pathlines.
    /// @param time of entry, in frames  @param span at least 1
    /// @return of mean 0, with the standard deviation of uniform noise in [0, 1]
    [[nodiscard]] float entering(const openvdb::Coord& voxel, double time, int span) const;
    /// Whether a voxel takes the value of entering fluid in a step: at random, with the probability that its fluid
    /// comes from outside. @param stayed share of the voxel's fluid, 0 to 1, that was inside one step before
    [[nodiscard]] bool fromOutside(const openvdb::Coord& voxel, std::uint64_t step, float stayed) const;

  private:
    std::uint32_t mSeed;
    openvdb::FloatGrid::ConstPtr mGrid;
};

/// The input of the first step: the noise, fixed-point (kNoiseMax), on a domain's own leaves. Made in parallel.
[[nodiscard]] LeafValues<std::int32_t> noiseInput(const Domain& domain, const NoiseField& noise);
/// The same values on the given leaves, 0 outside the domain.
[[nodiscard]] LeafValues<float> noiseValues(const Domain& domain, const NoiseField& noise, Domain::Leaves on);

} // namespace vdblic
