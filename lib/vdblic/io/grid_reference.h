#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace vdblic {

/// What a user names as `FILE` or `FILE:GRID`.
struct GridReference {
    std::filesystem::path path;
    std::string grid; ///< empty if none is named
};

/// Split at the last colon, unless the whole is the name of a file that is there.
/// @throws ParameterError if the file's or the grid's name is empty
[[nodiscard]] GridReference parseGridReference(std::string_view text);

} // namespace vdblic
