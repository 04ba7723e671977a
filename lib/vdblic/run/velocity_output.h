#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/units.h"
#include "vdblic/flow/reference_frame.h"
#include "vdblic/run/texture_format.h"

#include <openvdb/openvdb.h>

#include <string_view>

namespace vdblic {

/// The velocity's name in AdvectParams::derived, and its grid's name, which other programs expect (docs/formats.md).
inline constexpr std::string_view kVelocityName = "velocity";
inline constexpr const char* kVelocityGrid = "vel";

/// The velocity for motion blur: a Vec3 grid on voxel centres, in world units per second.
///
/// @param domain     the voxels of the grid; all must be here
/// @param velocities on voxel centres, in any unit
/// @param toWorld    from the velocities in world units per second, at places of their grid, to the result's
/// @param like       nothing, or the grid that gives voxels and transform for the interpolation
/// @param precision  in a file; half only where it has the range of the values (saveAsHalf())
/// Computed in parallel; the result does not depend on the number of threads.
[[nodiscard]] openvdb::Vec3SGrid::Ptr velocityGrid(const Domain& domain, const openvdb::Vec3SGrid& velocities,
                                                   const FromStored<Space::kWorld, Per::kSecond>& unit,
                                                   const VelocityMap& toWorld, const openvdb::FloatGrid* like,
                                                   GridPrecision precision);

} // namespace vdblic
