#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/refinement.h"
#include "vdblic/methods/streaks/streak_params.h"

#include <openvdb/openvdb.h>

#include <array>
#include <cstddef>
#include <string>

namespace vdblic {

/// The size of all streaks of a run.
struct StreakShape {
    /// A streak's thickness at half its height, at the head [spacings].
    static constexpr float kThickness = 0.156f;
    static constexpr float kRim = 1.848f; ///< rim of a streak, in radii at half height: (1 − 1/kRim²)² = ½

    std::array<float, 3> spacing{}; ///< [voxels of the velocity]
    float tail = 0;                 ///< [frames]
    Refinement refinement{};        ///< texture voxels in a voxel of the velocity

    /// The distance from a head's axis at which a streak has half its height [texture voxels], no less than voxels can
    /// show.
    [[nodiscard]] float radius(int axis) const;
    /// The largest visible distance of a streak from its axis [velocity voxels].
    [[nodiscard]] float reach() const;
    /// "spacing 2, tail 3.1, refine 8"
    [[nodiscard]] std::string text() const;
};

/// The shape that parameters give. Defaults suit unknown data: about as many streaks as a picture holds, tails of six
/// spacings for the faster half of the flow, and voxels that resolve a streak's thickness.
///
/// @param refinement   as given; its factors count only if the user gave them
/// @param domain       voxels of the velocity
/// @param displacement of the flow's faster half in a frame [voxels of the velocity]
/// @throws ParameterError if a given spacing is larger than the domain
[[nodiscard]] StreakShape streakShape(const StreakParams& params, const Refinement& refinement, const Domain& domain,
                                      double displacement);

/// The same from the size of a domain alone. @param voxels of the velocity, in `box`
[[nodiscard]] StreakShape streakShape(const StreakParams& params, const Refinement& refinement, std::size_t voxels,
                                      const openvdb::CoordBBox& box, double displacement);

} // namespace vdblic
