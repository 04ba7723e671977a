#pragma once

#include <openvdb/openvdb.h>

#include <filesystem>
#include <string>

namespace vdblic {

/// File metadata that names the texture's grid.
inline constexpr const char* kTextureKey = "texture";

/// The name of the texture's grid in a file: as given, else by the file's metadata, else `density`.
[[nodiscard]] std::string textureName(const openvdb::MetaMap& fileMetadata, const std::string& given);
/// The same for a file that is not read yet; empty if its header cannot be read.
[[nodiscard]] std::string textureName(const std::filesystem::path& path, const std::string& given);

} // namespace vdblic
