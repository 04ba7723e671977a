#pragma once

#include "vdblic/io/vdb_file.h"

#include <openvdb/openvdb.h>

#include <string>
#include <vector>

namespace vdblic {

/// The grids of a file that hold a velocity, of single or double precision.
struct VelocityGrids {
    std::string name;           ///< "velocity", or "vel.x, vel.y, vel.z"
    openvdb::GridPtrVec values; ///< one Vec3 grid, or the three scalar grids x, y and z
};

/// The names of the velocities in a file, the preferred one first: Vec3 grids, then three scalars, called `velocity`,
/// `vel` or `v`; then scalars `u,v,w` and `U,V,W`.
[[nodiscard]] std::vector<std::string> velocityNames(const VdbFile& file);

/// The names of all Vec3 grids, but for those that are known to mean something else, such as `vorticity`.
[[nodiscard]] std::vector<std::string> vectorNames(const VdbFile& file);

/// The velocity of a name: a Vec3 grid, or scalars `N.x N.y N.z`, `N_x N_y N_z`, `Nx Ny Nz`, `NX NY NZ` and so on; of
/// three names with commas between: those scalars.
/// @throws InputError if there is none
[[nodiscard]] VelocityGrids findVelocityGrids(const VdbFile& file, const std::string& name);

/// Whether a grid holds vectors that can be velocities.
[[nodiscard]] bool isVector(const openvdb::GridBase& grid);

} // namespace vdblic
