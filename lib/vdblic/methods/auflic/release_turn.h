#pragma once

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"
#include "vdblic/methods/auflic/particle_bins.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>

namespace vdblic {

/// Whether a tile releases seeds in a step: in one substep of each frame, which differs from tile to tile.
/// @param origin of the tile
[[nodiscard]] inline bool isReleaseTurn(const openvdb::Coord& origin, std::uint64_t step, int substeps)
{
    const auto part = [&](int axis) {
        return std::uint64_t(std::uint32_t(origin[axis] >> LeafVoxel::kLog2Dim)) & 0x1FFFFF;
    };
    // Fibonacci hashing (Knuth, The Art of Computer Programming 3, section 6.4).
    const std::uint64_t hash = (part(0) << 42 | part(1) << 21 | part(2)) * 0x9E3779B97F4A7C15u >> 32;
    const auto count = std::uint64_t(substeps);
    return step % count == hash * count >> 32;
}

/// A step relative to the frames of particles, which begin at the substep of release.
class FrameTurn {
  public:
    FrameTurn(std::uint64_t step, int substeps) : mSubsteps(std::uint64_t(substeps)), mEnding((step + 1) % mSubsteps) {}

    /// The substep of a particle's release.
    [[nodiscard]] VDBLIC_INLINE std::size_t substepOf(std::uint64_t id) const
    {
        return mSubsteps == 1 ? 0 : std::size_t((id >> Particle::kVoxelBits) % mSubsteps); // mostly without a division
    }
    /// Whether the step ends a frame of the particle.
    [[nodiscard]] VDBLIC_INLINE bool endsFrameOf(std::uint64_t id) const { return substepOf(id) == mEnding; }

  private:
    std::uint64_t mSubsteps, mEnding;
};

} // namespace vdblic
