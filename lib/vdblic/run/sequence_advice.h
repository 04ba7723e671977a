#pragma once

#include "vdblic/run/sequence_info.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace vdblic {

/// What a sequence needs before its texture is worth computing or looking at, each with the option that gives it.
[[nodiscard]] std::vector<std::string> adviceFor(const SequenceInfo& info);

/// The grid of the velocity, or the first of three scalars; null if there is none.
[[nodiscard]] const GridInfo* velocityGridOf(const SequenceInfo& info);

/// The axis along which a box has a single layer of voxels; −1: none, or several.
[[nodiscard]] int layerAxis(const openvdb::CoordBBox& box);

/// Factors on the world's axes that give a flat domain, such as weather, a height; nothing if it is not flat.
[[nodiscard]] std::optional<std::array<double, 3>> stretchOf(const GridInfo& grid);

/// Whether a flow makes streaks that can be seen and stay in place. @param moves displacement of its faster half
/// [voxels a step]
[[nodiscard]] bool makesStreaks(double moves);

/// What to do about a flow that moves too little or too far in a step for streaks; nothing if it does neither.
/// @param moves  displacement of its faster half [voxels a step]
/// @param frames of the sequence, those that are used
/// @param others units with which it would move some voxels, "voxel/s: 3.2"
[[nodiscard]] std::optional<std::string> motionAdvice(double moves, const std::vector<std::int64_t>& frames,
                                                      const std::vector<std::string>& others = {});

/// Frames as a frame list takes them: "1-4,8".
[[nodiscard]] std::string frameListText(const std::vector<std::int64_t>& frames);

} // namespace vdblic
