#include "vdblic/cast/solid_mesh.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/hazard.h"
#include "vdblic/io/input_file.h"

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>
#include <system_error>
#include <utility>

namespace vdblic {
namespace {

/// Every edge of a closed surface belongs to as many triangles in one direction as in the other.
bool isClosed(const std::vector<openvdb::Vec3I>& triangles)
{
    std::map<std::pair<unsigned, unsigned>, int> balance;
    for (const openvdb::Vec3I& triangle : triangles) {
        for (int i = 0; i < 3; ++i) {
            const unsigned a = triangle[i], b = triangle[(i + 1) % 3];
            if (a < b) {
                ++balance[{a, b}];
            } else {
                --balance[{b, a}];
            }
        }
    }
    for (const auto& [edge, sum] : balance) {
        if (sum != 0) return false;
    }
    return true;
}

/// Vertices at one place become one, whatever normals and texture coordinates the file gives them.
unsigned indexOf(const aiVector3D& v, std::map<std::array<float, 3>, unsigned>& known, TriangleMesh& mesh)
{
    const auto [found, isNew] = known.try_emplace({v.x, v.y, v.z}, unsigned(mesh.points.size()));
    if (isNew) mesh.points.emplace_back(v.x, v.y, v.z);
    return found->second;
}

} // namespace

bool isMeshFile(const std::filesystem::path& path)
{
    const std::string extension = path.extension().string();
    return extension == ".obj" || extension == ".stl" || extension == ".ply";
}

TriangleMesh readMesh(const std::filesystem::path& path)
{
    const auto refuse = [&](const std::string& reason) {
        return InputError(fmt::format("{}: {}", path.string(), reason));
    };
    checkRegular(path);
    std::error_code error;
    const auto size = std::filesystem::file_size(path, error);
    if (error) throw refuse(error.message());
    Assimp::Importer importer;
    const aiScene* scene = nullptr;
    {
        const Hazard parsing(path.string(), size);
        scene = importer.ReadFile(path.string(), aiProcess_Triangulate | aiProcess_PreTransformVertices);
    }
    if (!scene) throw refuse(fmt::format("is no mesh that can be read: {}", importer.GetErrorString()));
    TriangleMesh mesh;
    std::map<std::array<float, 3>, unsigned> known;
    for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
        const aiMesh& part = *scene->mMeshes[m];
        for (unsigned f = 0; f < part.mNumFaces; ++f) {
            const aiFace& face = part.mFaces[f];
            if (face.mNumIndices != 3) continue; // points and lines have no surface
            openvdb::Vec3I corners;
            for (unsigned i = 0; i < 3; ++i) {
                const aiVector3D& v = part.mVertices[face.mIndices[i]];
                if (!std::isfinite(v.x + v.y + v.z)) throw refuse("a vertex is not a finite number");
                corners[int(i)] = indexOf(v, known, mesh);
            }
            if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0])
                mesh.triangles.push_back(corners);
        }
    }
    if (mesh.triangles.empty()) throw refuse("holds no triangle");
    if (!isClosed(mesh.triangles)) throw refuse("its surface is not closed, so that it has no inside; close its holes");
    return mesh;
}

} // namespace vdblic
