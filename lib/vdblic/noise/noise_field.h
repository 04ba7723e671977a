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
    /// Those of the corners of a cube, z the fastest. @param first corner  @param edge of the cube [voxels]
    /// @param values receives eight
    void atCorners(const openvdb::Coord& first, int edge, std::int32_t* values) const;

    /// White noise that is new in every step: of a voxel and any number, as a step's.
    [[nodiscard]] std::int32_t ofStep(const openvdb::Coord& voxel, std::uint64_t number) const;

    /// The noise that fluid brings which entered the domain through a voxel: white noise of the frames, averaged over
    /// `span` frames around the time of entry, as the noise farther upstream would be along pathlines.
    /// @param time of entry, in frames  @param span at least 1
    /// @return of mean 0, scaled to the standard deviation of uniform noise in [0, 1]
    [[nodiscard]] float entering(const openvdb::Coord& voxel, double time, int span) const;
    /// Whether a voxel takes the value of entering fluid in a step: at random, as often as its fluid comes from
    /// outside.
    /// @param stayed the part of the voxel's fluid, 0 to 1, that was inside a step ago
    [[nodiscard]] bool fromOutside(const openvdb::Coord& voxel, std::uint64_t step, float stayed) const;

  private:
    std::uint32_t mSeed;
    openvdb::FloatGrid::ConstPtr mGrid;
};

/// The input of the first step: the noise, fixed-point (kNoiseMax), on a domain's own leaves. Made in parallel.
[[nodiscard]] LeafValues<std::int32_t> noiseInput(const Domain& domain, const NoiseField& noise);
/// The same numbers on the given leaves, 0 where the domain has no voxel.
[[nodiscard]] LeafValues<float> noiseValues(const Domain& domain, const NoiseField& noise, Domain::Leaves on);

} // namespace vdblic
