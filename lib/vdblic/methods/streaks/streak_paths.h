#pragma once

#include "vdblic/field/leaf_owners.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/pathline_params.h"
#include "vdblic/methods/streaks/streak.h"
#include "vdblic/methods/streaks/streak_controller.h"

#include <cstddef>
#include <vector>

namespace vdblic {

/// A part of a frame's time, and its flow.
struct StreakTurn {
    const VelocityField& field; ///< over the frame, in voxels of the velocity; not refined
    const Domain& end;          ///< velocity voxels at the turn's end; streaks elsewhere stop
    double frame;               ///< time of the frame's beginning [frames since the run began]
    float from, to;             ///< of the frame, 0 to 1
    float reach;                ///< largest visible distance of a streak from its path [velocity voxels]

    [[nodiscard]] double endTime() const { return frame + double(to); }
};

/// Advance the live streaks over a turn (advancePaths()). Each rank advances those in its own leaves and sends them to
/// the others, so all ranks have all streaks. Collective; computed in parallel. @return integration steps of all ranks
std::size_t advanceStreaks(const StreakTurn& turn, const PathlineParams& params, const LeafOwners& owners,
                           std::vector<Streak>& streaks);

/// Add streaks at places, at the end of a turn. If a streak's path entered over a rim during the turn, it has its path
/// since then, and slid in if it came into sight in this frame; else it begins at its place. What has not slid in fades
/// in. Collective; computed in parallel.
/// @param region that releases streaks: its rims count
void addStreaks(const StreakTurn& turn, const PathlineParams& params, const Domain& region,
                const std::vector<StreakPlace>& places, const LeafOwners& owners, std::vector<Streak>& streaks);

/// Add the first streaks of a run, each with a whole tail, as if the flow had always been that of the turn's beginning.
/// Collective; computed in parallel. @param tail length [frames]
void addFirstStreaks(const StreakTurn& turn, const PathlineParams& params, const Domain& region, double tail,
                     const std::vector<StreakPlace>& places, const LeafOwners& owners, std::vector<Streak>& streaks);

} // namespace vdblic
