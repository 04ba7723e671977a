#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/units.h"

#include <openvdb/openvdb.h>

#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// The scalars that derivedGrids() computes from a velocity: `vorticity`, |curl v| [1/s], and `q`, the Q criterion
/// [1/s²].
inline constexpr std::string_view kDerivedNames[] = {"vorticity", "q"};

/// @throws ParameterError if a name is not in kDerivedNames or appears twice
void checkDerivedNames(const std::vector<std::string>& names);

/// Scalars of the velocity's gradient in world space, on the voxels of a domain.
///
/// With J the gradient, vorticity is the length of the curl and q = ½(|Ω|² − |S|²) = −½ tr J², where Ω and S are J's
/// antisymmetric and symmetric parts: above 0 where rotation outweighs strain (Hunt, Wray & Moin 1988).
/// Differences are central between active voxels of the velocity, one-sided where one neighbour is missing, 0 where
/// both are: exact for a velocity that is linear in space, second order inside, first order at rims and holes.
/// @param velocities       on voxel centres, in any unit; active at least on the domain
/// @return fog volumes on the velocity's transform, in the order of the names
[[nodiscard]] std::vector<openvdb::FloatGrid::Ptr> derivedGrids(const std::vector<std::string>& names,
                                                                const Domain& domain,
                                                                const openvdb::Vec3SGrid& velocities,
                                                                const FromStored<Space::kWorld, Per::kSecond>& unit);

/// The share of a velocity's gradient J that is rotation beyond strain: Σ max(q, 0) / Σ ½|J|² over at most some million
/// voxels in evenly chosen leaves. 1 for a rigid rotation; 0 for shear, strain and uniform flow, and where neighbours
/// differ by no more than rounding. Differences as in derivedGrids().
[[nodiscard]] double rotationShare(const openvdb::Vec3SGrid& velocities,
                                   const FromStored<Space::kWorld, Per::kSecond>& unit);

} // namespace vdblic
