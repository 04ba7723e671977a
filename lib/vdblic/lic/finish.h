#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/flow/velocity_frame.h"

namespace vdblic {

/// Finishing of a texture for display. The next step does not see it.
struct FinishParams {
    int taps = 2;         ///< samples to each side along the flow, a voxel apart; 0 for none
    float sharpen = 0.5f; ///< strength of the high-pass filter after that

    void validate() const; ///< @throws ParameterError
};

/// A frame's texture, finished for display: meanAlongFlow(), then sharpened to restore the contrast.
///
/// @param interval seconds between frames
/// @param texture in [0, 1], on the frame's domain; 0 outside. If moved in, freed before the result is made
/// @return in [0, 1], on the frame's domain. Computed in parallel; the result does not depend on the number of threads.
[[nodiscard]] LeafValues<float> finish(const VelocityFrame& frame, double interval, LeafValues<float> texture,
                                       const FinishParams& params);

} // namespace vdblic
