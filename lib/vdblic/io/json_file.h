#pragma once

#include <nlohmann/json_fwd.hpp>

#include <filesystem>

namespace vdblic {

/// Read a JSON file. @throws InputError naming the file, and line, column and reason if it is no JSON
[[nodiscard]] nlohmann::json readJson(const std::filesystem::path& path);

} // namespace vdblic
