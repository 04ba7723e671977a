#pragma once

#include <openvdb/openvdb.h>

#include <filesystem>
#include <optional>
#include <string>

namespace vdblic {

/// The content of a file without its voxels: metadata, and grids with empty trees.
struct VdbHeader {
    openvdb::MetaMap metadata;
    openvdb::GridPtrVec grids; ///< empty trees, with metadata and transform
};

/// Read the header of a file, after the checks of readLayout().
/// @return no grids if the file does not say where they are, which few writers omit
/// @throws InputError naming the file and the reason
[[nodiscard]] VdbHeader readVdbHeader(const std::filesystem::path& path);

/// Remove metadata that have OpenVDB's own names but other types: OpenVDB throws when it sets them.
void removeForeignMetadata(const openvdb::GridPtrVec& grids);

/// The bounding box of a grid's active voxels, as its writer stored it; few writers omit it.
[[nodiscard]] std::optional<openvdb::CoordBBox> storedBox(const openvdb::GridBase& grid);

/// The part of a grid that a file stores before the voxels.
struct GridHeader {
    openvdb::math::Transform::Ptr transform;
    openvdb::CoordBBox box; ///< of the active voxels; empty if there are none
};

/// The header of the first grid of a name.
/// @return nothing if there is none, or it lacks the bounding box of its voxels, which few writers omit
[[nodiscard]] std::optional<GridHeader> gridHeader(const VdbHeader& file, const std::string& name);

} // namespace vdblic
