#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/units.h"
#include "vdblic/run/texture_format.h"

#include <openvdb/openvdb.h>

#include <string_view>

namespace vdblic {

/// The name among AdvectParams::derived that asks for the velocity, and that of its grid, by which other programs find
/// it (docs/formats.md).
inline constexpr std::string_view kVelocityName = "velocity";
inline constexpr const char* kVelocityGrid = "vel";

/// The velocity for motion blur: a Vec3 grid on voxel centres, in world units per second.
///
/// @param domain     whose voxels it has; all of them must be here
/// @param velocities on voxel centres, in any unit
/// @param like       nothing, or the grid on whose voxels and transform it is interpolated
/// @param precision  of the numbers in a file; half is left out where it would cost precision (saveAsHalf())
/// Computed in parallel; the result does not depend on the number of threads.
[[nodiscard]] openvdb::Vec3SGrid::Ptr velocityGrid(const Domain& domain, const openvdb::Vec3SGrid& velocities,
                                                   const FromStored<Space::kWorld, Per::kSecond>& unit,
                                                   const openvdb::FloatGrid* like, GridPrecision precision);

} // namespace vdblic
