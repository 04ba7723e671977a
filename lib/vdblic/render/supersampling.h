#pragma once

#include "vdblic/render/ray_caster.h"

namespace vdblic {

inline constexpr int kMostSamples = 4096; ///< rays to a pixel

/// As castRays(), with several rays to a pixel, of which it gets the mean; of the layers the mean by alpha.
///
/// The rays' places are the first of a low-discrepancy sequence (Roberts' R2) over the pixel, the first its centre: the
/// same in every pixel, and with one sample castRays()'s own picture.
[[nodiscard]] Image castSamples(const TextureVolume& volume, const Look& look, const Camera& camera,
                                const RayCastParams& params, int samples);

} // namespace vdblic
