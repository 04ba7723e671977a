#pragma once

#include "vdblic/io/vdb_file.h"
#include "vdblic/lic/feedback.h"
#include "vdblic/lic/flow_frame.h"
#include "vdblic/lic/scatter.h"
#include "vdblic/lic/steady_lic.h"

#include <memory>
#include <optional>

namespace vdblic {

/// A step between two frames.
struct FlowStep {
    const FlowFrame& start;
    const FlowFrame& end;
    openvdb::Mat3d startToStep, endToStep; ///< stored values of the two frames → voxels per step
    double interval = 1;                   ///< seconds
};

/// Seconds spent, in the parts of the paper's Table 2.
struct StageTimes {
    double load = 0;     ///< building the field from what was read
    double scatter = 0;  ///< advancing pathlines and depositing values
    double convolve = 0; ///< dividing sums by hits
    double filter = 0;   ///< sharpening, contrast and noise

    StageTimes& operator+=(const StageTimes& other);
};

/// A texture and what it took to make it.
struct FlowTextureStep {
    LeafValues<float> texture; ///< in [0, 1], on the domain of the step's first frame
    ScatterStats stats;
    StageTimes times;
};

/// The UFLIC pipeline: scatter, convolve, filter, feed forward (Liu & Moorhead 2004, Figure 1a); or steadyLic() of each
/// frame on its own.
class FlowTexture {
  public:
    /// @param steady if it has a value, every frame is convolved on its own with this kernel, and of `scatter` only the
    ///               life span and the pathlines' parameters count
    /// @throws ParameterError
    FlowTexture(const ScatterParams& scatter, const FeedbackParams& feedback, NoiseField noise,
                std::optional<LicKernel> steady = std::nullopt);

    /// Compute the texture of the frame a step starts from. Steps must follow each other: each starts from the frame
    /// that the one before ended at.
    FlowTextureStep advance(const FlowStep& step);

    /// The number of steps made.
    [[nodiscard]] std::uint64_t steps() const { return mStep; }

    /// What the next step starts from, as the grids of flow_state.h; none for steady LIC, which starts anew in every
    /// frame. At least one step must have been made.
    [[nodiscard]] openvdb::GridPtrVec save() const;

    /// Go on where another FlowTexture with these parameters was when it saved its state: what follows is the same to
    /// the bit.
    ///
    /// @param steps    that it had made
    /// @param interval seconds of the last of them
    /// @param domain   of the frame that the next step starts from
    /// @throws InputError, without the file's name, if the state is none of such a FlowTexture and domain
    void restore(std::uint64_t steps, double interval, std::shared_ptr<const Domain> domain, const VdbFile& state);

  private:
    ScatterParams mParams;
    FeedbackParams mFeedback;
    NoiseField mNoise;
    std::optional<LicKernel> mSteady;
    Scatter mScatter;
    VelocityField mField;
    std::shared_ptr<const Domain> mDomain; // of the step to come
    std::optional<LeafValues<std::int32_t>> mInput;
    double mLastInterval = 0;
    std::uint64_t mStep = 0;
};

} // namespace vdblic
