#pragma once

#include <filesystem>

namespace vdblic {

/// Refuse an input that is not a regular file, before it is opened: a pipe or a device may block for ever. A missing
/// file passes, and fails when opened.
/// @throws InputError naming the file
void checkRegular(const std::filesystem::path& path);

/// Whether a path leads to anything but a folder.
[[nodiscard]] bool isFile(const std::filesystem::path& path);

} // namespace vdblic
