#pragma once

#include "vdblic/look/look.h"
#include "vdblic/look/transfer_params.h"
#include "vdblic/look/volume_values.h"

#include <vector>

namespace vdblic {

/// Transfer functions for a scalar whose values number kinds, such as the sources of streaks.

/// Give each kind a colour and an equal part of the range. Given colours are read at the middle of each kind's part;
/// by default the kinds have colours that eyes tell apart, and 0, no kind, is grey. With a given range the scalar
/// shows as numbers.
void colorByKind(TransferParams& params);

/// One opacity for all kinds, and a smaller one for unclassified voxels. Scaled as in chooseLook().
/// @param samples    not empty, with the kinds as drivers
/// @param voxelDepth mean optical depth of a voxel
[[nodiscard]] std::vector<OpacityPoint> opacityOfKinds(const VolumeSamples& samples, double voxelDepth,
                                                       const TextureModulation& texture, std::size_t kinds);

} // namespace vdblic
