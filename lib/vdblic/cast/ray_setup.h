#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/cast/ray_task.h"
#include "vdblic/field/vector.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstdint>
#include <optional>
#include <vector>

namespace vdblic {

class SampleShader;
class TextureVolume;
class VisibleSpace;
struct RayCastParams;

/// The share of a step by which the steps of a pixel's ray are shifted along it, so that shells of samples leave no
/// rings: blue noise over the picture (blue_noise.h), which shows no pattern on opaque surfaces. The shifts of a
/// pixel's further rays are spread evenly between (van der Corput's sequence).
/// @param ray index among the pixel's rays
[[nodiscard]] float sampleShift(int x, int y, int ray = 0);

/// Turns pixels into rays to trace: the span of each ray inside the volume's bounds and all cuts. Thread-safe.
class RaySetup {
  public:
    static constexpr int kTile = 16;            ///< pixels a side
    static constexpr int kRays = kTile * kTile; ///< of a tile

    /// @param ray  index among each pixel's rays
    /// @param begins, ends depths at which the pixels' rays begin and end, as SurfacePicture has them; or null
    /// @param only by pixel: whether it has a ray; or null: all have
    RaySetup(const TextureVolume& volume, const VisibleSpace& visible, const Camera& camera,
             const RayCastParams& params, const SampleShader& shader, int ray, const float* begins, const float* ends,
             const std::uint8_t* only);

    /// The rays through the centres of a tile's pixels that meet the volume, in an order that keeps neighbours
    /// together.
    /// @param x, y  top left pixel of the tile; pixels outside the picture are left out
    /// @param tasks receives up to kRays rays
    /// @return number of rays
    int rays(int x, int y, RayTask* tasks) const;

  private:
    /// A plane that cuts the rays of a picture.
    struct Cut {
        PictureGradient<double> above, slope; // height of a ray's origin above the plane, and its growth along the ray
        double lensRight, lensUp;             // change of the height along the lens's axes
    };
    /// The lens's axes, in world space and in index space.
    struct LensAxes {
        Lens world, index;
    };

    const SampleShader& mShader;
    glm::ivec2 mSize;
    double mStep;
    int mRay;
    const float *mBegins, *mEnds;
    const std::uint8_t* mOnly;
    PictureRays mWorld, mIndex; // in world space, and in index space relative to VisibleSpace::origin()
    glm::dvec3 mLow, mHigh;     // the volume's bounds, as mIndex
    std::optional<LensAxes> mLens;
    std::vector<Cut> mCuts;
    std::vector<Float4> mOutward; // normals of the bounds' low and high faces, axis by axis, and of the cuts
};

} // namespace vdblic
