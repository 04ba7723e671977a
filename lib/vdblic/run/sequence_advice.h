#pragma once

#include "vdblic/run/sequence_info.h"

#include <string>
#include <vector>

namespace vdblic {

/// What a sequence needs before its texture is worth computing or looking at, each with the option that gives it.
[[nodiscard]] std::vector<std::string> adviceFor(const SequenceInfo& info);

/// Frames as a frame list takes them: "1-4,8".
[[nodiscard]] std::string frameListText(const std::vector<std::int64_t>& frames);

} // namespace vdblic
