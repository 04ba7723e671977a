#pragma once

#include "vdblic/run/sequence_info.h"

#include <optional>
#include <string>
#include <vector>

namespace vdblic {

/// What a sequence needs before its texture is worth computing or looking at, each with the option that gives it.
[[nodiscard]] std::vector<std::string> adviceFor(const SequenceInfo& info);

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
