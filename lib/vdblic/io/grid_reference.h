#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace vdblic {

/// A grid that a user names as `FILE` or `FILE:GRID`.
struct GridReference {
    std::filesystem::path path;
    std::string grid; ///< empty for `FILE`
};

/// Split at the last colon, unless a file of the whole name exists.
/// @throws ParameterError if the file's or the grid's name is empty
[[nodiscard]] GridReference parseGridReference(std::string_view text);

} // namespace vdblic
