#pragma once

#include "vdblic/field/bricks.h"
#include "vdblic/field/frame_domain.h"

namespace vdblic {

struct TextureParams;

/// \file
/// What the estimates of all methods are made of. Fitted to measured runs.

/// Bytes of the process, and for each voxel of the velocity's leaves.
inline constexpr double kProcessBytes = 44e6, kVelocityBytes = 29;
/// Bytes for each leaf with velocities in bricks.
inline constexpr double kVelocityBrickBytes = sizeof(float) * 8 * BricksOf<8>::kSize;

/// The part of a domain whose bricks are in memory at a time: three slabs of whole layers, as of a cube.
[[nodiscard]] double partInBricks(double leaves);

/// The memory of a method on the texture's voxels: velocity, texture and bricks of both.
/// @param more  bytes for each texture voxel beside those of auflic with history
[[nodiscard]] double denseBytes(const TextureParams& params, const FrameDomain& first, double more);

/// The same for a run with default parameters. @param voxels of the velocity's leaves
[[nodiscard]] double denseBytes(double voxels);

} // namespace vdblic
