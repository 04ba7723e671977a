#pragma once

#include "vdblic/methods/streaks/streak_params.h"
#include "vdblic/methods/texture_method.h"

#include <openvdb/openvdb.h>

namespace vdblic {

struct StreakShape;

/// Sparse: particles with tails that live for many frames (StreakTexture). Ours (docs/methods.md); Liu & Moorhead
/// (2004, section 3.1) explain why sparse noise cannot be fed to AUFLIC.
extern const TextureMethod kStreaks;

/// The cost of a run of streaks, fitted to measured runs as TextureMethod::bytes is.
struct StreakCost {
    double streaks;         ///< per frame
    double bytes;           ///< peak memory
    double secondsPerFrame; ///< of processor time
};
/// @param voxels of the velocity, in `box`  @param leaves of the velocity
[[nodiscard]] StreakCost streakCost(const StreakShape& shape, StreakForm form, double voxels, double leaves,
                                    const openvdb::CoordBBox& box);

} // namespace vdblic
