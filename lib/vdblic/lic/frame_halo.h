#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/lic/flow_sequence.h"

#include <openvdb/openvdb.h>

#include <array>

namespace vdblic {

/// Reduce a frame that was read to a rank's part: its velocities and its own leaves. Carried grids stay at rank 0,
/// which writes them.
void keepOwn(LoadedFrame& frame, int rank);

/// How far paths lead that no step between two frames exceeds.
struct Farthest {
    std::array<float, 3> path;     ///< of a pathline in a step, along each axis [texture voxels]
    std::array<float, 3> upstream; ///< from where the feedback takes its texture, along each axis [texture voxels]
};

/// Give both frames of a step what lies around a rank's part, as far as the step can reach. Collective.
/// @return depth of the halo [texture voxels], the same at every rank
openvdb::Coord surround(Exchange& exchange, LoadedFrame& start, LoadedFrame& end, const Farthest& farthest);

} // namespace vdblic
