#include "vdblic/field/analytic_flow.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/globe.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace vdblic {
namespace {

using openvdb::Vec3d;
using std::numbers::pi;

double squared(double x)
{
    return x * x;
}

FlowFunction makeUniform(const Vec3d&)
{
    return [](const Vec3d&, double) { return Vec3d(6, 3, 2) / 7; };
}

/// v = ω ẑ × r. The speed's root mean square over the box is 1.
FlowFunction makeRotation(const Vec3d& extent)
{
    const double rate = std::sqrt(12 / (squared(extent.x()) + squared(extent.y())));
    return [rate](const Vec3d& p, double) { return rate * Vec3d(-p.y(), p.x(), 0); };
}

/// The ABC flow (Dombre, Frisch, Greene, Hénon, Mehr & Soward, "Chaotic streamlines in the ABC flows", J. Fluid Mech.
/// 167, 1986), with A : B : C = √3 : √2 : 1,
///     v = (A sin z + C cos y, B sin x + A cos z, C sin y + B cos x),
/// one period to the unit of length, made unsteady by moving its phases to and fro, x → x + ε sin Ωt and likewise for
/// y and z (Brummell, Cattaneo & Tobias, "Linear and nonlinear dynamo properties of time-dependent ABC flows", Fluid
/// Dyn. Res. 28, 2001). The speed's root mean square is 1.
FlowFunction makeAbc(const Vec3d&)
{
    return [](const Vec3d& p, double time) {
        constexpr double kEpsilon = 1, kOmega = pi;
        const double norm = std::sqrt(6.0);
        const double a = std::sqrt(3.0) / norm, b = std::sqrt(2.0) / norm, c = 1 / norm;
        const double shift = kEpsilon * std::sin(kOmega * time);
        const double x = 2 * pi * p.x() + shift, y = 2 * pi * p.y() + shift, z = 2 * pi * p.z() + shift;
        return Vec3d(a * std::sin(z) + c * std::cos(y), b * std::sin(x) + a * std::cos(z),
                     c * std::sin(y) + b * std::cos(x));
    };
}

/// A vortex along z with the Lamb–Oseen profile (Saffman, Vortex Dynamics, 1992, 13.1; the core does not grow here),
///     v_θ = G/r (1 − exp(−r²/c²)),  v_z = W exp(−r²/c²),
/// r being the horizontal distance from an axis that is wound into a helix and whirls about the box's centre line,
///     axis(z, t) = R (cos φ, sin φ),  φ = κz + ωt.
/// The updraft follows the axis: with v_z goes the horizontal velocity v_z ∂axis/∂z, which keeps the divergence 0.
FlowFunction makeTornado(const Vec3d&)
{
    return [](const Vec3d& p, double time) {
        constexpr double kSwirl = 0.3, kCore = 0.1, kUpdraft = 1.5;
        constexpr double kRadius = 0.12, kPitch = pi, kWhirl = pi;
        const double phase = kPitch * p.z() + kWhirl * time;
        const double axisX = kRadius * std::cos(phase), axisY = kRadius * std::sin(phase);
        const double x = p.x() - axisX, y = p.y() - axisY;
        const double r2 = x * x + y * y;
        const double rate = r2 > 0 ? -std::expm1(-r2 / squared(kCore)) / r2 : 1 / squared(kCore);
        const double updraft = kUpdraft * std::exp(-r2 / squared(kCore));
        return Vec3d(-kSwirl * rate * y - updraft * kPitch * axisY, kSwirl * rate * x + updraft * kPitch * axisX,
                     updraft);
    };
}

/// The time-periodic double gyre (Shadden, Lekien & Marsden, "Definition and properties of Lagrangian coherent
/// structures from finite-time Lyapunov exponents in two-dimensional aperiodic flows", Physica D 212, 2005) in x–y,
///     ψ = A sin(π f(x, t)) sin(πy),  f = ε sin(ωt) x² + (1 − 2ε sin(ωt)) x,  x in [0, 2], y in [0, 1],
/// stretched over the whole box. A steady cell in y–z of amplitude A/4 connects the layers. No flow passes the box's
/// walls. A is chosen for a root mean square speed of about 1.
FlowFunction makeGyre(const Vec3d& extent)
{
    constexpr double kCell = 0.25;
    const double amplitude = 2 / std::sqrt(squared(extent.x() / 2) + squared(extent.y()) * (1 + squared(kCell)) +
                                           squared(extent.z() * kCell));
    return [extent, amplitude](const Vec3d& p, double time) {
        constexpr double kEpsilon = 0.25, kOmega = pi;
        const double x = 2 * p.x() / extent.x() + 1;
        const double y = pi * (p.y() / extent.y() + 0.5);
        const double z = pi * (p.z() / extent.z() + 0.5);
        const double quadratic = kEpsilon * std::sin(kOmega * time);
        const double f = quadratic * x * x + (1 - 2 * quadratic) * x;
        const double slope = 2 * quadratic * x + 1 - 2 * quadratic;
        const double u = -std::sin(pi * f) * std::cos(y);
        const double v = std::cos(pi * f) * std::sin(y) * slope - kCell * std::sin(y) * std::cos(z);
        const double w = kCell * std::cos(y) * std::sin(z);
        return amplitude * Vec3d(u * extent.x() / 2, v * extent.y(), w * extent.z());
    };
}

/// Hill's spherical vortex, the fattest of the vortex rings (Hill, "On a spherical vortex", Phil. Trans. R. Soc. A 185,
/// 1894; Lamb, Hydrodynamics, 165), held in the box by a head wind as fast as the ring,
/// V = 1. With z along the axis, r the distance from it, R² = r² + z² and a the sphere's radius,
///     inside:  v_r = 3/2 V rz/a²,    v_z = 3/2 V (1 − (2r² + z²)/a²),
///     outside: v_r = 3/2 V a³rz/R⁵,  v_z = V (a³/R³ (1 − 3/2 r²/R²) − 1).
/// Its radius pulsates while it moves to and fro along the axis.
FlowFunction makeRing(const Vec3d&)
{
    return [](const Vec3d& p, double time) {
        constexpr double kRadius = 0.36, kPulse = 0.15, kWay = 0.15;
        const double a2 = squared(kRadius * (1 + kPulse * std::sin(2 * pi * time)));
        const double z = p.z() - kWay * std::sin(pi * time);
        const double r2 = squared(p.x()) + squared(p.y());
        const double distance2 = r2 + z * z;
        if (distance2 <= a2) {
            const double radial = 1.5 * z / a2;
            return Vec3d(radial * p.x(), radial * p.y(), 1.5 * (1 - (r2 + distance2) / a2));
        }
        const double ratio2 = a2 / distance2;
        const double decay = ratio2 * std::sqrt(ratio2); // a³/R³
        const double radial = 1.5 * decay * z / distance2;
        return Vec3d(radial * p.x(), radial * p.y(), decay * (1 - 1.5 * r2 / distance2) - 1);
    };
}

FlowFunction makeRossby(const Vec3d&)
{
    return rossbyWave;
}

constexpr AnalyticFlow kFlows[] = {
    {"abc", "Arnold-Beltrami-Childress flow whose phases move to and fro; chaotic", makeAbc},
    {"gyre", "two gyres side by side, one growing while the other shrinks; walled in by the box", makeGyre},
    {"ring", "spherical vortex ring in a head wind that pulsates and moves to and fro along z", makeRing},
    {"rossby", "Rossby-Haurwitz wave on the Earth, whose pattern turns at a known speed; without --size", makeRossby,
     true},
    {"rotation", "rigid rotation about z; steady, with known pathlines", makeRotation},
    {"tornado", "helical vortex with an updraft in its core that whirls about z", makeTornado},
    {"uniform", "the same velocity everywhere, along (6, 3, 2); steady, with known pathlines", makeUniform},
};

} // namespace

std::span<const AnalyticFlow> analyticFlows()
{
    return kFlows;
}

const AnalyticFlow& findAnalyticFlow(std::string_view name)
{
    std::string known;
    for (const AnalyticFlow& flow : kFlows) {
        if (flow.name == name) return flow;
        known += fmt::format("{}{}", known.empty() ? "" : ", ", flow.name);
    }
    throw ParameterError(fmt::format("there is no flow '{}'; choose one of {}", name, known));
}

FlowFunction flowInBox(const AnalyticFlow& flow, const BoxSize& size, double voxelSize)
{
    if (flow.isOnGlobe) throw ParameterError(fmt::format("the flow '{}' is on a globe, not in a box", flow.name));
    checkBoxSize(size);
    checkVoxelSize(voxelSize);
    BoxSize sorted = size;
    std::sort(sorted.begin(), sorted.end());
    const double length = sorted[1] * voxelSize;
    const double speed = kFlowSpeed * voxelSize;
    const Vec3d voxels(size[0], size[1], size[2]);
    const Vec3d centre = 0.5 * voxelSize * (voxels - Vec3d(1));
    return [function = flow.make(voxels / sorted[1]), centre, length, speed](const Vec3d& position, double time) {
        return speed * function((position - centre) / length, time * speed / length);
    };
}

} // namespace vdblic
