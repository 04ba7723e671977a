#pragma once

#include <openvdb/openvdb.h>

#include <filesystem>
#include <optional>
#include <string>

namespace vdblic {

/// The part of a grid that a file stores before the voxels.
struct GridHeader {
    openvdb::math::Transform::Ptr transform;
    openvdb::CoordBBox box; ///< of the active voxels; empty if there are none
};

/// Read the header of the first grid of a name.
/// @return nothing if there is none, or it lacks the bounding box of its voxels, which few writers omit
/// @throws InputError naming the file and the reason
[[nodiscard]] std::optional<GridHeader> readGridHeader(const std::filesystem::path& path, const std::string& name);

} // namespace vdblic
