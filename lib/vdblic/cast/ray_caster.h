#pragma once

#include "vdblic/cast/surface_picture.h"
#include "vdblic/image/image.h"

#include <cstdint>
#include <stop_token>

namespace vdblic {

class Camera;
class TextureVolume;
class VisibleSpace;
struct Look;
struct RayCastParams;

/// Cast a ray through each pixel's centre, front to back, with early termination.
///
/// Cuts and the active voxels' bounds leave a span of each ray. It is cut at multiples of the step from the eye plus
/// the pixel's shift: relative to the eye, so that no slope of a face cancels the shifts. A sample lies in the middle
/// of its step; the first and the last step may be shorter. A sample whose voxel, which covers [i − ½, i + ½), is not
/// shown has no opacity. Optical depth counts voxels passed in index space, so a picture does not change with the unit
/// of length. Samples within a voxel of the face where their ray enters are lit as that face. The pixels do not depend
/// on the number of threads. Thread-safe.
/// @param params  valid
/// @param visible leaves that are sampled; the others are skipped
/// @param ray     index among the pixel's rays, for sampleShift() (ray_setup.h)
/// @param scenery rays end at its surfaces, which are seen with the transmittance that is left; its tubes divide rays,
///                and voxels and tubes are blended in the order in which a ray meets them
/// @param only    by pixel: whether to cast its ray, the others stay 0; null: all
/// @param stop    asks for the end before the picture is complete
/// @throws Stopped if a stop was requested
[[nodiscard]] Image castRays(const TextureVolume& volume, const Look& look, const Camera& camera,
                             const RayCastParams& params, const VisibleSpace& visible, int ray = 0,
                             const Scenery& scenery = {}, const std::uint8_t* only = nullptr,
                             const std::stop_token& stop = {});

} // namespace vdblic
