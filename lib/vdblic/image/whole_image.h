#pragma once

#include <filesystem>

namespace vdblic {

/// Whether a file is a whole image of its extension's format, .exr or .png: all of its pixels can be read.
[[nodiscard]] bool isWholeImage(const std::filesystem::path& path);

} // namespace vdblic
