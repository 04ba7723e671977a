#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/ray_caster.h"
#include "vdblic/image/image.h"
#include "vdblic/volume/visible_leaves.h"

#include <stop_token>

namespace vdblic {

inline constexpr int kMostSamples = 4096; ///< rays per pixel

/// A picture that is cast ray by ray of its pixels.
class SampleSum {
  public:
    /// @param volume, look, scenery must outlive this
    SampleSum(const TextureVolume& volume, const Look& look, const Camera& camera, const RayCastParams& params,
              const Scenery& scenery);

    /// Cast the next ray of every pixel. @throws Stopped, with the sum as it was, if a stop is requested
    void add(const std::stop_token& stop = {});
    [[nodiscard]] int count() const { return mCount; }
    /// The picture of the rays so far, at least one; that of castSamples().
    [[nodiscard]] Image mean() const;

  private:
    const TextureVolume& mVolume;
    const Look& mLook;
    Camera mCamera;
    RayCastParams mParams;
    Scenery mScenery;
    VisibleLeaves mVisible;
    Image mSum; // of the first ray alone its layers are not weighted yet
    int mCount = 0;
};

/// As castRays(), with several rays per pixel. A pixel is the mean of its rays, a layer their mean weighted by alpha.
///
/// The rays of every pixel start at the same points of it: the first ones of a low-discrepancy sequence (Roberts' R2)
/// that begins at the centre. With one ray the picture is that of castRays().
[[nodiscard]] Image castSamples(const TextureVolume& volume, const Look& look, const Camera& camera,
                                const RayCastParams& params, int samples, const Scenery& scenery = {});

} // namespace vdblic
