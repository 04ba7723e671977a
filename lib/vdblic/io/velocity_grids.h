#pragma once

#include "vdblic/io/vdb_file.h"

#include <string>
#include <vector>

namespace vdblic {

/// A velocity found in a file, on voxel centres.
struct VelocityGrid {
    std::string name; ///< "velocity", or "vel.x, vel.y, vel.z"
    openvdb::Vec3SGrid::Ptr values;
    bool staggered = false; ///< the components stood on the voxels' faces
};

/// The linear part of a transform: its columns are the index axes in world space.
[[nodiscard]] openvdb::Mat3d indexAxes(const openvdb::math::Transform& transform);

/// The names under which the file holds a velocity, first the one to take: Vec3 grids, then three scalars, called
/// `velocity`, `vel` or `v`; failing these, any Vec3 grid.
[[nodiscard]] std::vector<std::string> velocityNames(const VdbFile& file);

/// The velocity of a name: a Vec3 grid (float or double), or scalars `N.x N.y N.z`, `N_x N_y N_z`, `Nx Ny Nz`.
///
/// Staggered components, by grid class or by transforms that differ by half a voxel, are averaged to the voxel
/// centres. Where the face beyond has no value the nearer one stands for both.
/// @param path of the file, for messages
/// @throws InputError if there is none, or its transform is a frustum, sheared, or not the same for all components
[[nodiscard]] VelocityGrid findVelocity(const VdbFile& file, const std::string& name, const std::string& path);

} // namespace vdblic
