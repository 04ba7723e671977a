#pragma once

#include <openvdb/openvdb.h>

#include <filesystem>
#include <optional>
#include <string>

namespace vdblic {

/// What a file says of a grid before its voxels.
struct GridHeader {
    openvdb::math::Transform::Ptr transform;
    openvdb::CoordBBox box; ///< of the active voxels; empty if there are none
};

/// Read the header of the first grid of a name; nothing if there is none, or it does not say where its voxels are
/// (few writers leave that out).
/// @throws InputError naming the file and the reason
[[nodiscard]] std::optional<GridHeader> readGridHeader(const std::filesystem::path& path, const std::string& name);

} // namespace vdblic
