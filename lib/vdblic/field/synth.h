#pragma once

#include "vdblic/core/parameters.h"
#include "vdblic/core/reporter.h"
#include "vdblic/field/analytic_flow.h"

#include <openvdb/openvdb.h>

#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace vdblic {

/// Parameters of a synthetic velocity sequence.
struct SynthParams {
    std::string flow;              ///< the name of one of analyticFlows()
    std::string output;            ///< a pattern, or a file if there is one frame
    std::optional<BoxSize> size{}; ///< voxels along x, y and z; none on a globe
    std::string frames;            ///< a frame list; frame 1 is at time 0
    std::optional<double> dt{};    ///< seconds from one frame number to the next; unset: SynthFlow::dt()
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

/// A flow and the voxels that it is sampled on. Immutable; thread-safe.
class SynthFlow {
  public:
    /// @param size of the box; none on a globe
    /// @throws ParameterError if the name is unknown, the size is missing or superfluous, or a number is out of bounds;
    ///         InputError if the voxels exceed the memory
    SynthFlow(std::string_view name, const std::optional<BoxSize>& size, double voxelSize);

    /// The default of the seconds from one frame number to the next: the flow moves by about 3 voxels.
    [[nodiscard]] static double dt(const AnalyticFlow& flow, double voxelSize);

    /// The grid of sampleFlow(); on a globe with the metadata `length_unit`, and behind it speedOnEarth() and the grids
    /// of Globe.
    [[nodiscard]] openvdb::GridPtrVec at(double time) const;

  private:
    openvdb::math::Transform::Ptr mTransform;
    FlowFunction mFlow;
    std::shared_ptr<const Domain> mDomain;
    openvdb::GridPtrVec mFixed; // the same at all times
};

/// Write one file a frame with the grids of SynthFlow. The velocity has the metadata `frame` (int64), `time` and `dt`
/// (double, in seconds).
///
/// A frame's time depends only on its number, so parts of a sequence can be made separately.
/// @throws ParameterError, OutputError
void synthSequence(const SynthParams& params, Reporter& reporter);

} // namespace vdblic
