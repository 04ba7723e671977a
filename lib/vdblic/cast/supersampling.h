#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/ray_caster.h"
#include "vdblic/image/image.h"

#include <cstdint>
#include <stop_token>
#include <vector>

namespace vdblic {

class VisibleSpace;

inline constexpr int kMostSamples = 4096; ///< rays per pixel

/// The sum of a picture's rays, added one a pixel at a time: two for each pixel, further ones only where these two
/// differ or a neighbour in the same tile of RaySetup differs. Elsewhere further rays would change nothing visible.
/// Through a lens every pixel has all rays. A pixel is the mean of its rays, a layer their mean weighted by alpha.
///
/// The rays of every pixel start at the same points of it: the first ones of a low-discrepancy sequence (Roberts' R2)
/// that begins at the centre. With one ray the picture is that of castRays().
class SampleSum {
  public:
    /// @param volume, look, visible, scenery must outlive this
    SampleSum(const TextureVolume& volume, const Look& look, const VisibleSpace& visible, const Camera& camera,
              const RayCastParams& params, const Scenery& scenery);

    /// Cast the next ray of every pixel that needs one. @throws Stopped, with the sum as it was, if a stop is requested
    void add(const std::stop_token& stop = {});
    [[nodiscard]] int count() const { return mCount; }
    /// The picture of the rays so far, at least one.
    [[nodiscard]] Image mean() const;

  private:
    const TextureVolume& mVolume;
    const Look& mLook;
    const VisibleSpace& mVisible;
    Camera mCamera;
    RayCastParams mParams;
    Scenery mScenery;
    Image mSum, mFirst; // of the first ray alone the sum's layers are not weighted yet; colours of the first ray
    std::vector<std::uint8_t> mRefined; // by pixel: whether it needs more than two rays; empty before that is known
    int mCount = 0;
};

} // namespace vdblic
