#pragma once

#include "vdblic/run/sequence_info.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace vdblic {

/// Advice before computing or viewing a sequence's texture, each with its option.
[[nodiscard]] std::vector<std::string> adviceFor(const SequenceInfo& info);

/// The grid of the velocity, or the first of three scalars; null if there is none.
[[nodiscard]] const GridInfo* velocityGridOf(const SequenceInfo& info);

/// The axis along which a box has a single layer of voxels; −1: none, or several.
[[nodiscard]] int layerAxis(const openvdb::CoordBBox& box);

/// World-axis factors that give a flat domain, such as weather, a height; nothing if it is not flat.
[[nodiscard]] std::optional<std::array<double, 3>> stretchOf(const GridInfo& grid);

/// Whether a flow makes visible, stable streaks. @param moves displacement of its faster half [voxels a step]
[[nodiscard]] bool makesStreaks(double moves);

/// Advice on a flow with too small or too large steps for streaks; nothing if they suit.
/// @param moves  displacement of its faster half [voxels a step]
/// @param frames used frames of the sequence
/// @param others units that give suitable steps, "voxel/s: 3.2"
[[nodiscard]] std::optional<std::string> motionAdvice(double moves, const std::vector<std::int64_t>& frames,
                                                      const std::vector<std::string>& others = {});

/// Frames as a frame list: "1-4,8".
[[nodiscard]] std::string frameListText(const std::vector<std::int64_t>& frames);

} // namespace vdblic
