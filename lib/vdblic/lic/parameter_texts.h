#pragma once

#include <string>
#include <utility>
#include <vector>

namespace vdblic {

struct AdvectParams;

/// Parameters by name, as text: `--life`, `4`. Empty where nothing is given.
using ParameterTexts = std::vector<std::pair<std::string, std::string>>;

/// Every parameter that has a say in the content of a run's outputs, but for the input sequence itself; the text of a
/// file includes its stamp.
[[nodiscard]] ParameterTexts parameterTexts(const AdvectParams& params);

} // namespace vdblic
