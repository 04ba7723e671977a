#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace vdblic {

/// What tells whether a file was changed, as a text: its size, when it was modified, and the identity in a .vdb's
/// header, which every writer makes anew and ours make from the checksums. Reads no more than the header.
[[nodiscard]] std::string fileStamp(const std::filesystem::path& path);

/// The parts of two stamps that differ, for messages. Parts are separated by ", ".
[[nodiscard]] std::string stampDifference(std::string_view then, std::string_view now);

} // namespace vdblic
