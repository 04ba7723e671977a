#pragma once

#include <string>
#include <string_view>

namespace vdblic::cli {

/// A message of the library in the words of a tool: each parameter in backticks, such as `max_memory`, becomes the
/// option that sets it, --max-memory. Anything else in backticks stays.
/// @param tool its name; a few options differ between tools
[[nodiscard]] std::string withOptionNames(std::string_view message, std::string_view tool);

} // namespace vdblic::cli
