#pragma once

#include <string>
#include <utility>
#include <vector>

namespace vdblic {

struct AdvectPlan;

/// Parameters by key, as text: `life_span`, `4`. Empty where nothing is given. Checkpoints store them by these keys,
/// so the keys stay as they are, whatever a program calls its options.
using ParameterTexts = std::vector<std::pair<std::string, std::string>>;

/// Every parameter that has a say in the content of a run's outputs, but for the input sequence itself; the text of a
/// file includes its stamp.
[[nodiscard]] ParameterTexts parameterTexts(const AdvectPlan& plan);

} // namespace vdblic
