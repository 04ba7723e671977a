#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace vdblic {

/// A text that changes when a file changes: its size, its time of modification, and the identity in a .vdb's header,
/// which other writers choose at random and ours derive from the checksums. Reads only the header.
[[nodiscard]] std::string fileStamp(const std::filesystem::path& path);

/// The parts in which two stamps differ, for messages.
[[nodiscard]] std::string stampDifference(std::string_view then, std::string_view now);

} // namespace vdblic
