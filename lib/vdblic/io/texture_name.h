#pragma once

#include <openvdb/openvdb.h>

#include <filesystem>
#include <string>
#include <vector>

namespace vdblic {

struct SequenceParams;

/// File metadata that names the texture's grid.
inline constexpr const char* kTextureKey = "texture";

/// File metadata about inactive voxels of the texture: kEmpty; without it they have no value.
inline constexpr const char *kInactiveKey = "inactive", *kEmpty = "empty";

/// Whether inactive voxels of a file's texture are empty.
[[nodiscard]] bool isSparse(const openvdb::MetaMap& fileMetadata);
/// The same for a sequence, by its first file; false if that cannot be read.
[[nodiscard]] bool isSparse(const SequenceParams& sequence);

/// The grid of the sources of streaks, and file metadata that names them: kSourceKey with 1, 2 and so on after it.
inline constexpr const char *kSourceGrid = "source", *kSourceKey = "source_";
/// The names of a file's sources, from number 1 on; empty if it has none.
[[nodiscard]] std::vector<std::string> sourceNames(const openvdb::MetaMap& fileMetadata);

/// The name of the texture's grid in a file: as given, else by the file's metadata, else `density`.
[[nodiscard]] std::string textureName(const openvdb::MetaMap& fileMetadata, const std::string& given);
/// The same for a file that is not read yet; empty if its header cannot be read.
[[nodiscard]] std::string textureName(const std::filesystem::path& path, const std::string& given);

} // namespace vdblic
