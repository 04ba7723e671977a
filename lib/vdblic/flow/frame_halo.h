#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/flow/flow_sequence.h"

#include <openvdb/openvdb.h>

#include <array>
#include <memory>
#include <vector>

namespace vdblic {

/// Reduce a frame that was read to a rank's part: its velocities and its own leaves. Carried grids stay at rank 0,
/// which writes them.
void keepOwn(LoadedFrame& frame, int rank);

/// Give each rank its part of a frame in another partition. Collective.
void handOver(Exchange& exchange, LoadedFrame& frame, std::shared_ptr<const Partition> partition);

/// How far paths lead that no step between two frames exceeds, from a rank's own voxels.
struct Farthest {
    std::array<float, 3> path;     ///< of a pathline in a step, along each axis [texture voxels]
    std::array<float, 3> upstream; ///< from where the feedback takes its texture, along each axis [texture voxels]
};

/// How deep each rank's halo must be [texture voxels], whole leaves. Fast voxels make those halos deeper that paths can
/// lead to them from, or from them: no path leaves the ranks that its halo touches. Collective; all ranks return the
/// same.
[[nodiscard]] std::vector<openvdb::Coord> haloDepths(Exchange& exchange, const Partition& partition,
                                                     const Farthest& farthest);

/// Give a frame what lies around a rank's part. Collective.
/// @param depths of all ranks' halos
void surround(Exchange& exchange, LoadedFrame& frame, const std::vector<openvdb::Coord>& depths);

} // namespace vdblic
