#pragma once

#include <openvdb/openvdb.h>

#include <filesystem>
#include <vector>

namespace vdblic {

/// The triangles of a mesh file in its own coordinates.
struct TriangleMesh {
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
};

/// Whether a file is a mesh, by its extension: .obj, .stl or .ply.
[[nodiscard]] bool isMeshFile(const std::filesystem::path& path);

/// @throws InputError naming the file if it cannot be read, holds no triangle, or its surface is not closed
[[nodiscard]] TriangleMesh readMesh(const std::filesystem::path& path);

} // namespace vdblic
