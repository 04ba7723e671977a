#pragma once

#include "methods/auflic/literal_path.h"
#include "vdblic/field/domain.h"
#include "vdblic/flow/velocity_frame.h"
#include "vdblic/methods/auflic/feedback_params.h"
#include "vdblic/noise/noise_field.h"

#include <cstdint>

namespace vdblic::test {

/// The mean of a texture along the line of flow through each voxel: five samples, a voxel apart along its velocity,
/// with the weights 1 2 3 2 1; what lies outside the domain does not count (docs/algorithm.md). Voxel by voxel.
LeafValues<float> literalMeanAlongFlow(const VelocityFrame& frame, const LeafValues<float>& texture);

/// The next input: the texture sharpened, taken half a step upstream, its contrast restored, a share of the noise
/// added; fluid that has come in brings noise (Shen & Kao 1998, section 3.3; docs/algorithm.md). Voxel by voxel.
/// @param next domain of the step to come  @param step number of the step that made the texture
LeafValues<std::int32_t> literalFeedForward(const LiteralField& field, const LeafValues<float>& texture,
                                            const Domain& next, const NoiseField& noise, const FeedbackParams& params,
                                            std::uint64_t step);

} // namespace vdblic::test
