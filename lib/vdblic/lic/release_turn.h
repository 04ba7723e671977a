#pragma once

#include "vdblic/field/leaf_voxel.h"

#include <openvdb/openvdb.h>

#include <cstdint>

namespace vdblic {

/// Whether a tile releases seeds in a step: in one of each frame's substeps, which differs from tile to tile.
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

} // namespace vdblic
