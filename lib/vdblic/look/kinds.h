#pragma once

#include "vdblic/look/look.h"
#include "vdblic/look/transfer_params.h"
#include "vdblic/look/volume_values.h"

#include <vector>

namespace vdblic {

/// What transfer functions are for a scalar whose values are the numbers of kinds, such as the sources of streaks.

/// Give each kind a colour and as much of the range. Colours that are chosen are those of the middle of each kind's
/// part of the range; by default the kinds have colours that eyes tell apart, and 0, none of them, is grey. A range of
/// one's own shows numbers and no kinds.
void colorByKind(TransferParams& params);

/// Opacity that is the same for all kinds, and less for what is of none. It is scaled as chooseLook() says.
/// @param samples    not empty, with the kinds as drivers
/// @param voxelDepth mean optical depth of a voxel
[[nodiscard]] std::vector<OpacityPoint> opacityOfKinds(const VolumeSamples& samples, double voxelDepth,
                                                       const TextureModulation& texture, std::size_t kinds);

} // namespace vdblic
