#pragma once

#include "vdblic/field/leaf_owners.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/pathline_params.h"
#include "vdblic/methods/streaks/streak.h"
#include "vdblic/methods/streaks/streak_controller.h"

#include <cstddef>
#include <vector>

namespace vdblic {

/// A part of a frame's time, and the flow in it.
struct StreakTurn {
    const VelocityField& field; ///< over the frame, in voxels of the velocity; not refined
    const Domain& end;          ///< voxels of the velocity at the turn's end; a streak elsewhere is stopped
    double frame;               ///< when the frame begins [frames since the run began]
    float from, to;             ///< of the frame, 0 to 1
    float reach;                ///< how far a streak can be seen from its path [voxels of the velocity]

    [[nodiscard]] double endTime() const { return frame + double(to); }
};

/// Advance the live streaks over a turn (advancePaths()). Each rank advances those that its own leaves hold and tells
/// the others, so all ranks have all streaks. Collective; computed in parallel. @return integration steps, of all ranks
std::size_t advanceStreaks(const StreakTurn& turn, const PathlineParams& params, const LeafOwners& owners,
                           std::vector<Streak>& streaks);

/// Add streaks at places, at the end of a turn. A streak whose path came in over a rim during the turn has slid in: it
/// has had its path since then. Another one begins where it is, and fades in. Collective; computed in parallel.
/// @param region that releases: its rims count
void addStreaks(const StreakTurn& turn, const PathlineParams& params, const Domain& region,
                const std::vector<StreakPlace>& places, const LeafOwners& owners, std::vector<Streak>& streaks);

/// Add the first streaks of a run, each with a whole tail, as if the flow had always been that of the turn's
/// beginning. Collective; computed in parallel. @param tail in frames
void addFirstStreaks(const StreakTurn& turn, const PathlineParams& params, const Domain& region, double tail,
                     const std::vector<StreakPlace>& places, const LeafOwners& owners, std::vector<Streak>& streaks);

} // namespace vdblic
