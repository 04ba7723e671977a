#pragma once

#include "vdblic/field/velocity_field.h"
#include "vdblic/methods/auflic/feedback_params.h"
#include "vdblic/noise/noise_field.h"

#include <cstdint>

namespace vdblic {

/// The next step's input: the texture sharpened, carried on to the next frame's time, and jittered.
///
/// The texture is the mean over a step: it shows features where they were half a step before the next frame. So a
/// voxel's input is the sharpened texture half a step upstream, by the midpoint rule. Without that shift features would
/// lag behind the flow (docs/algorithm.md).
///
/// A voxel that is new in the next domain takes the original noise. Fluid that enters the domain brings the noise of
/// its place and time of entry (NoiseField::entering()), so that streaks enter without cuts. A voxel takes this noise
/// with the probability that its fluid was outside a step ago. Near a slow inlet its own values, fed back alone, would
/// freeze into streaks as long as the domain.
///
/// With substeps, read "frame" for "step" above. Only tiles that release seeds in the next step get an input; the
/// others keep the original noise, which is not read.
///
/// @param field    velocity over the step that made the texture, prepared; filled and released here
/// @param texture  in [0, 1], on the field's domain, its halo included; 0 outside
/// @param next     domain of the step to come
/// @param step     number of the texture's step
/// @param substeps steps in a frame
/// @return values on the own leaves of `next`, fixed-point (kNoiseMax). Computed in parallel; the result does not
/// depend on the number of threads. Shen & Kao 1998, section 3.3; Liu & Moorhead 2004, section 1.
[[nodiscard]] LeafValues<std::int32_t> feedForward(VelocityField& field, const LeafValues<float>& texture,
                                                   const Domain& next, const NoiseField& noise,
                                                   const FeedbackParams& params, std::uint64_t step, int substeps = 1);

} // namespace vdblic
