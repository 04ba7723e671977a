#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <openvdb/openvdb.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace vdblic {

class EarthMap;

/// An opaque body: a level set on a lattice of unit voxels, so that any affine transform can place it. Immutable; any
/// number of threads may read.
struct Solid {
    openvdb::FloatGrid::Ptr levelSet; ///< with the identity as transform; distances in its voxels; below 0 inside
    glm::dmat4 worldToIndex{1};       ///< from the world of the picture, stretched, to its index space
    std::shared_ptr<const EarthMap> earth{}; ///< colours its surface; null: one colour
    double share = 0;                        ///< of the texture's box, for the solid `domain`
};

/// The largest share of inactive voxels in a texture's box that counts as a body or a ground; around clouds it is
/// larger.
inline constexpr double kMostSolid = 0.2;

/// Read or make the solid of a frame.
///
/// Masks, fog volumes (where they are above 0) and the domain become level sets of their voxels, meshes of the
/// texture's.
/// @param source  `domain`: the inactive voxels in the box around the texture's. Else FILE or FILE:GRID, one file or a
///                sequence with the input's frame numbers: a closed mesh (.obj, .stl, .ply), or the level set, fog
///                volume or mask of a .vdb
/// @param texture of that frame
/// @param stretch factors along the axes from the grids' world space to the picture's
/// @throws InputError naming the file, the grid and the mend
[[nodiscard]] Solid makeSolid(const std::string& source, const openvdb::FloatGrid& texture, const glm::dvec3& stretch,
                              std::int64_t frame);
/// Whether each frame has a solid of its own.
[[nodiscard]] bool solidChanges(const std::string& source);

/// The box around the voxels inside a solid, in its index space.
[[nodiscard]] openvdb::CoordBBox boundsOf(const Solid& solid);

/// Points around a solid, in the picture's world: corners of parts of its surface, about a thousand of the outermost;
/// nothing without a surface.
[[nodiscard]] std::vector<glm::dvec3> solidExtent(const Solid& solid);

} // namespace vdblic
