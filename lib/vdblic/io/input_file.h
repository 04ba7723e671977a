#pragma once

#include <filesystem>

namespace vdblic {

/// Refuse an input that is no regular file, before it is opened: on a pipe or a device opening or reading may wait for
/// ever. What does not exist passes, and fails when it is opened.
/// @throws InputError naming the file
void checkRegular(const std::filesystem::path& path);

/// Whether a path leads to anything but a folder.
[[nodiscard]] bool isFile(const std::filesystem::path& path);

} // namespace vdblic
