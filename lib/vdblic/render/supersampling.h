#pragma once

#include "vdblic/render/image.h"
#include "vdblic/render/ray_caster.h"

namespace vdblic {

inline constexpr int kMostSamples = 4096; ///< rays per pixel

/// As castRays(), with several rays per pixel. A pixel is the mean of its rays, a layer their mean weighted by alpha.
///
/// The rays of every pixel start at the same points of it: the first ones of a low-discrepancy sequence (Roberts' R2)
/// that begins at the centre. With one ray the picture is that of castRays().
[[nodiscard]] Image castSamples(const TextureVolume& volume, const Look& look, const Camera& camera,
                                const RayCastParams& params, int samples, const Scenery& scenery = {});

} // namespace vdblic
