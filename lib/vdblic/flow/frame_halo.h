#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/distributed/partition.h"
#include "vdblic/field/units.h"
#include "vdblic/flow/velocity_frame.h"

#include <memory>
#include <vector>

namespace vdblic {

/// Reduce a frame to a rank's part: its velocities and its own leaves. Carried grids stay at rank 0, their writer.
void keepOwn(VelocityFrame& frame, int rank);

/// Redistribute a frame's parts by another partition. Collective.
void handOver(Exchange& exchange, VelocityFrame& frame, std::shared_ptr<const Partition> partition);

/// Upper bounds of the lengths of paths in a step between two frames, from a rank's own voxels.
struct Farthest {
    Lengths<Space::kTexture> path;     ///< of a pathline in a step
    Lengths<Space::kTexture> upstream; ///< from where the feedback takes its texture
};

/// The depth of each rank's halo, whole leaves: no path leaves the ranks that its halo touches. Fast voxels deepen only
/// the halos that touch their rank. Collective; all ranks return the same.
/// @param period of the texture
[[nodiscard]] std::vector<Rim<Space::kTexture>> haloDepths(Exchange& exchange, const Partition& partition,
                                                           const Farthest& farthest, const Period& period = {});

/// Add the halo to a rank's part of a frame. Collective.
/// @param depths of all ranks' halos
void surround(Exchange& exchange, VelocityFrame& frame, const std::vector<Rim<Space::kTexture>>& depths);

} // namespace vdblic
