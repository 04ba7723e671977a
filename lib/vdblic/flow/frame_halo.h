#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/distributed/partition.h"
#include "vdblic/field/units.h"
#include "vdblic/flow/velocity_frame.h"

#include <memory>
#include <vector>

namespace vdblic {

/// Reduce a frame that was read to a rank's part: its velocities and its own leaves. Carried grids stay at rank 0,
/// which writes them.
void keepOwn(VelocityFrame& frame, int rank);

/// Give each rank its part of a frame in another partition. Collective.
void handOver(Exchange& exchange, VelocityFrame& frame, std::shared_ptr<const Partition> partition);

/// How far paths lead that no step between two frames exceeds, from a rank's own voxels.
struct Farthest {
    Lengths<Space::kTexture> path;     ///< of a pathline in a step
    Lengths<Space::kTexture> upstream; ///< from where the feedback takes its texture
};

/// How deep each rank's halo must be, whole leaves. Fast voxels make those halos deeper that paths can
/// lead to them from, or from them: no path leaves the ranks that its halo touches. Collective; all ranks return the
/// same.
[[nodiscard]] std::vector<Rim<Space::kTexture>> haloDepths(Exchange& exchange, const Partition& partition,
                                                           const Farthest& farthest);

/// Give a frame what lies around a rank's part. Collective.
/// @param depths of all ranks' halos
void surround(Exchange& exchange, VelocityFrame& frame, const std::vector<Rim<Space::kTexture>>& depths);

} // namespace vdblic
