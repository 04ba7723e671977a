#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/image/image.h"

#include <cstdint>
#include <functional>
#include <stop_token>
#include <utility>
#include <vector>

namespace vdblic {

inline constexpr int kMostSamples = 4096; ///< rays per pixel

/// Add layers to sums, weighted by the alpha of the pixel that they are of.
void addLayers(PixelLayers& sum, const PixelLayers& layers, float alpha);
/// Turn sums into means. @param alpha sum of the weights
void divideLayers(PixelLayers& sum, float alpha);

/// The sum of a picture's rays, added one a pixel at a time: two for each pixel, further ones only where these two
/// differ or a neighbour in the same tile of RaySetup differs. Elsewhere further rays would change nothing visible.
/// Through a lens every pixel has all rays. A pixel is the mean of its rays, a layer their mean weighted by alpha.
///
/// The rays of every pixel start at the same points of it: the first ones of a low-discrepancy sequence (Roberts' R2)
/// that begins at the centre.
class SampleSum {
  public:
    /// Casts a ray through each pixel, or each pixel of `only`, as castRays() does.
    using Cast =
        std::function<Image(const Camera& camera, int ray, const std::uint8_t* only, const std::stop_token& stop)>;

    SampleSum(Cast cast, const Camera& camera) : mCast(std::move(cast)), mCamera(camera) {}

    /// Cast the next ray of every pixel that needs one. @throws Stopped, with the sum as it was, if a stop is requested
    void add(const std::stop_token& stop = {});
    [[nodiscard]] int count() const { return mCount; }
    /// The picture of the rays so far, at least one.
    [[nodiscard]] Image mean() const;

  private:
    Cast mCast;
    Camera mCamera;
    Image mSum, mFirst; // of the first ray alone the sum's layers are not weighted yet; colours of the first ray
    std::vector<std::uint8_t> mRefined; // by pixel: whether it needs more than two rays; empty before that is known
    int mCount = 0;
};

} // namespace vdblic
