#pragma once

#include "vdblic/render/clipping.h"
#include "vdblic/render/sample_shader.h"

namespace vdblic {

/// Turns pixels into rays to trace: where each comes into what is left of a volume, and out of it.
class RaySetup {
  public:
    static constexpr int kTile = 16; ///< pixels a side

    /// @param ray of a pixel's
    RaySetup(const TextureVolume& volume, const VisibleLeaves& visible, const Camera& camera,
             const RayCastParams& params, const SampleShader& shader, int ray);

    /// The rays through the centres of a tile's pixels that meet the volume, neighbours close to each other.
    /// @param x, y  its top left pixel; those beyond the picture are left out
    /// @param tasks room for kTile² of them  @return how many there are
    int rays(int x, int y, RayTask* tasks) const;

  private:
    /// A plane, as the rays of a picture meet it.
    struct Cut {
        PictureGradient<double> above, slope; // height of a ray's origin over it, and gain of height along the ray
    };

    const SampleShader& mShader;
    glm::ivec2 mSize;
    double mStep;
    int mRay;
    PictureRays mWorld, mIndex; // the second to places as VisibleLeaves count them
    glm::dvec3 mLow, mHigh;     // the volume's bounds there
    std::vector<Cut> mCuts;
    std::vector<Float4> mOutward; // normals of the bounds' low and high faces, axis by axis, and of the cuts
};

} // namespace vdblic
