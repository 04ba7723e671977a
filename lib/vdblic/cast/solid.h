#pragma once

#include "vdblic/cast/solid_params.h"

#include <glm/mat4x4.hpp>
#include <openvdb/openvdb.h>

#include <cstdint>

namespace vdblic {

/// An opaque body: a level set on a lattice of unit voxels, so that any affine transform can place it. Immutable; any
/// number of threads may read.
struct Solid {
    openvdb::FloatGrid::Ptr levelSet; ///< with the identity as transform; distances in its voxels; below 0 inside
    glm::dmat4 worldToIndex{1};       ///< from the world of the picture, stretched, to its index space
};

/// Read or make the solid of a frame.
///
/// Masks, fog volumes (where they are above 0) and the domain become level sets of their voxels, meshes of the
/// texture's.
/// @param texture of that frame
/// @param stretch factors along the axes from the grids' world space to the picture's
/// @throws InputError naming the file, the grid and the mend
[[nodiscard]] Solid makeSolid(const SolidParams& params, const openvdb::FloatGrid& texture, const glm::dvec3& stretch,
                              std::int64_t frame);

/// The box around the voxels inside a solid, in its index space.
[[nodiscard]] openvdb::CoordBBox boundsOf(const Solid& solid);

} // namespace vdblic
