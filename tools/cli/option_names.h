#pragma once

#include "vdblic/core/parameters.h"

#include <string>
#include <string_view>

namespace vdblic::cli {

/// A message of the library in the words of a tool: each parameter in backticks, such as `max_memory`, becomes the
/// option that sets it, --max-memory. Anything else in backticks stays.
/// @param parameters of the tool; other keys are spelled with dashes
[[nodiscard]] std::string withOptionNames(std::string_view message, const Parameters& parameters);

} // namespace vdblic::cli
