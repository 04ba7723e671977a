#pragma once

#include "vdblic/field/domain.h"

#include <openvdb/openvdb.h>

#include <memory>

namespace vdblic {

/// The Earth's radius in the world of a globe: its unit is 1,000 km, x leads to 0° E on the equator, z to the north
/// pole.
inline constexpr double kEarthRadius = 6.371;

/// The pattern of rossbyWave() turns eastward [radians per second].
inline constexpr double kRossbyRate = (4 * 7 * 7.848e-6 - 2 * 7.292e-5) / 30;

/// The Rossby–Haurwitz wave of wave number R = 4, an exact solution of the barotropic vorticity equation without
/// divergence, whose pattern turns unchanged (Haurwitz, "The motion of atmospheric disturbances on the spherical
/// earth", J. Mar. Res. 3, 1940; Phillips, "Numerical integration of the primitive equations on the hemisphere", Mon.
/// Weather Rev. 87, 1959; Williamson, Drake, Hack, Jakob & Swarztrauber, "A standard test set for numerical
/// approximations to the shallow water equations in spherical geometry", J. Comput. Phys. 102, 1992, test case 6):
///     ψ/a² = −ω sin φ + K cos⁴φ sin φ cos 4(λ − νt),  ν = (R(3 + R)ω − 2Ω)/((1 + R)(2 + R)),  ω = K = 7.848·10⁻⁶/s,
/// λ being the longitude, φ the latitude, Ω = 7.292·10⁻⁵/s the Earth's rate and ν kRossbyRate.
///
/// @param position [1,000 km] from the Earth's centre, where the velocity is 0  @param time [s]
/// @return [1,000 km per second], horizontal; the angular velocity is the same at each radius
[[nodiscard]] openvdb::Vec3d rossbyWave(const openvdb::Vec3d& position, double time);

/// Voxels of a globe, whose centres lie at whole multiples of their size: a shell on the Earth's surface with a margin
/// below and above. A flow along the shell's rims would leave it through the stairs of voxels there; in the margin it
/// goes on.
struct Globe {
    std::shared_ptr<const Domain> domain; ///< shell and margin
    openvdb::FloatGrid::Ptr rim;          ///< depth in the shell from its nearer rim [1,000 km]; below 0 in the margin
    openvdb::FloatGrid::Ptr solid;        ///< the Earth below the shell, a level set
};

/// @param voxelSize [1,000 km]  @throws ParameterError of checkGlobe(); InputError if the voxels exceed the memory
[[nodiscard]] Globe makeGlobe(double voxelSize);

/// The grid `speed` [m/s]: the speed on the Earth's surface, to which angular velocities belong at all radii.
/// @param velocity [1,000 km per second], on the domain
[[nodiscard]] openvdb::FloatGrid::Ptr speedOnEarth(const openvdb::Vec3SGrid& velocity, const Domain& domain);

/// @throws ParameterError if the voxels are too large to tell the shell from the Earth, or more than a box may have
void checkGlobe(double voxelSize);

/// Voxels of a globe's domain, about.
[[nodiscard]] double voxelsOfGlobe(double voxelSize);

} // namespace vdblic
