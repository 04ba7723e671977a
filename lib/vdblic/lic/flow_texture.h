#pragma once

#include "vdblic/lic/feedback.h"
#include "vdblic/lic/scatter.h"

#include <memory>
#include <optional>

namespace vdblic {

/// One frame of the flow: its domain, and its velocity over the steps that begin or end there.
struct FlowFrame {
    std::shared_ptr<const Domain> domain;
    openvdb::Vec3SGrid::ConstPtr velocities;
    openvdb::Mat3d toWorldPerSecond; ///< stored value → world units per second
};

/// A step between two frames.
struct FlowStep {
    const FlowFrame& start;
    const FlowFrame& end;
    openvdb::Mat3d startToStep, endToStep; ///< stored values of the two frames → voxels per step
    double interval = 1;                   ///< seconds
};

/// A texture and what it took to make it.
struct FlowTextureStep {
    LeafValues<float> texture; ///< in [0, 1], on the domain of the step's first frame
    ScatterStats stats;
};

/// The UFLIC pipeline: scatter, convolve, filter, feed forward (Liu & Moorhead 2004, Figure 1a).
class FlowTexture {
  public:
    /// @throws ParameterError
    FlowTexture(const ScatterParams& scatter, const FeedbackParams& feedback, NoiseField noise);

    /// Compute the texture of the frame a step starts from. Steps must follow each other: each starts from the frame
    /// that the one before ended at.
    FlowTextureStep advance(const FlowStep& step);

  private:
    FeedbackParams mFeedback;
    NoiseField mNoise;
    Scatter mScatter;
    VelocityField mField;
    std::optional<LeafValues<std::int32_t>> mInput;
    double mLastInterval = 0;
    std::uint64_t mStep = 0;
};

} // namespace vdblic
