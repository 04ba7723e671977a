#pragma once

#include "vdblic/core/parameters.h"
#include "vdblic/core/reporter.h"
#include "vdblic/field/analytic_flow.h"

#include <openvdb/openvdb.h>

#include <string>

namespace vdblic {

/// Parameters of a synthetic velocity sequence.
struct SynthParams {
    std::string flow;     ///< the name of one of analyticFlows()
    std::string output;   ///< a pattern, or a file if there is one frame
    BoxSize size{};       ///< voxels along x, y and z
    std::string frames;   ///< a frame list; frame 1 is at time 0
    double dt = 1.0 / 24; ///< seconds from one frame number to the next
    double voxelSize = kDefaultVoxelSize;

    /// @throws ParameterError
    void validate() const;
};
[[nodiscard]] Parameters parametersOf(SynthParams& params);

/// Sample a flow at one time on the active voxels of a domain: a grid `velocity` in world units per second, of the
/// vector type contravariant relative.
///
/// @param flow      world position, seconds → world units per second
/// @param transform of the grid
/// @param time      in seconds
/// Computed in parallel and in double precision.
[[nodiscard]] openvdb::Vec3SGrid::Ptr sampleFlow(const FlowFunction& flow, const Domain& domain,
                                                 const openvdb::math::Transform& transform, double time);

/// Write one file a frame with the grid of sampleFlow() and its metadata `frame` (int64), `time` and `dt` (double, in
/// seconds).
///
/// A frame's time depends only on its number, so parts of a sequence can be made separately.
/// @throws ParameterError, OutputError
void synthSequence(const SynthParams& params, Reporter& reporter);

} // namespace vdblic
