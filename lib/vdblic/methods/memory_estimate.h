#pragma once

#include "vdblic/field/bricks.h"
#include "vdblic/field/frame_domain.h"

namespace vdblic {

struct TextureParams;

/// \file
/// Parts of all methods' memory estimates, fitted to measured runs.

/// Bytes of the process, and per voxel of the velocity's leaves.
inline constexpr double kProcessBytes = 44e6, kVelocityBytes = 29;
/// Bytes per velocity leaf in bricks.
inline constexpr double kVelocityBrickBytes = sizeof(float) * 8 * BricksOf<8>::kSize;

/// The share of a cubic domain's bricks that is in memory at a time: three slabs of whole layers.
[[nodiscard]] double partInBricks(double leaves);

/// The memory of a method on the texture's voxels: velocity, texture and the bricks of both.
/// @param more  bytes per texture voxel beyond those of auflic with history
[[nodiscard]] double denseBytes(const TextureParams& params, const FrameDomain& first, double more);

/// The same for a run with default parameters. @param voxels of the velocity's leaves
[[nodiscard]] double denseBytes(double voxels);

/// The processor time of such a run (docs/evidence.md). @param voxels, frames of its textures
[[nodiscard]] double denseSeconds(double voxels, double frames);

} // namespace vdblic
