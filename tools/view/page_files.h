#pragma once

#include <optional>
#include <string_view>

namespace vdblic::view {

/// A file of the page, embedded in the program.
struct PageFile {
    std::string_view type, bytes;
};

/// @param name as in tools/view/page
[[nodiscard]] std::optional<PageFile> pageFile(std::string_view name);

} // namespace vdblic::view
