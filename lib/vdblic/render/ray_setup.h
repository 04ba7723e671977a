#pragma once

#include "vdblic/render/clipping.h"
#include "vdblic/render/sample_shader.h"

namespace vdblic {

/// Turns pixels into rays to trace: where each comes into what is left of a volume, and out of it.
class RaySetup {
  public:
    RaySetup(const TextureVolume& volume, const VisibleLeaves& visible, const Camera& camera,
             const RayCastParams& params, const SampleShader& shader, int ray);

    /// The ray through a pixel's centre; without samples if it misses.
    [[nodiscard]] RayTask ray(int x, int y) const;

  private:
    struct Cut {
        ClipPlane plane;
        glm::dvec3 outward; // of length 1
    };

    const Camera& mCamera;
    const SampleShader& mShader;
    double mStep;
    int mRay;               // of a pixel's
    glm::dmat4 mToIndex;    // from world space to places as VisibleLeaves count them
    glm::dvec3 mLow, mHigh; // the volume's bounds there
    glm::dvec3 mAlong[3];   // the normals of their faces, towards the high ones, in world space
    std::vector<Cut> mCuts;
};

} // namespace vdblic
