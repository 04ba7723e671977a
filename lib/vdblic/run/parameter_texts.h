#pragma once

#include <string>
#include <utility>
#include <vector>

namespace vdblic {

struct AdvectPlan;

/// Parameters by key, as text: `life_span`, `4`. Empty where not given. These keys are stored in checkpoints, so they
/// stay, whatever a program calls its options.
using ParameterTexts = std::vector<std::pair<std::string, std::string>>;

/// Every parameter that affects the content of a run's outputs, except the input sequence; the text of a file includes
/// its stamp.
[[nodiscard]] ParameterTexts parameterTexts(const AdvectPlan& plan);

} // namespace vdblic
