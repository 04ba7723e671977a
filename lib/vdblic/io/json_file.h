#pragma once

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <string>

namespace vdblic {

/// Read a JSON file. @throws InputError naming the file, and line, column and reason if it is no JSON
[[nodiscard]] nlohmann::json readJson(const std::filesystem::path& path);

/// JSON as a text with a line break at its end. Invalid UTF-8, as in names of files or grids, becomes U+FFFD.
/// @param indent spaces
[[nodiscard]] std::string jsonText(const nlohmann::json& json, int indent = 2);
[[nodiscard]] std::string jsonText(const nlohmann::ordered_json& json, int indent = 2);

} // namespace vdblic
