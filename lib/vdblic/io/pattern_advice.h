#pragma once

#include <filesystem>
#include <string>

namespace vdblic {

/// A pattern for files on disk called PREFIX, digits, SUFFIX; empty if there are none.
/// @param only the name of the one file to look at; empty: all
[[nodiscard]] std::string likelyPattern(const std::filesystem::path& folder, const std::string& prefix,
                                        const std::string& suffix, const std::string& only = {});

/// The pattern probably meant by a file name without a frame field that looks like a pattern, such as
/// `v.*.vdb`, `v.%4d.vdb` or a folder's name; empty if there is nothing to advise.
[[nodiscard]] std::string patternAdvice(const std::filesystem::path& pattern);

} // namespace vdblic
