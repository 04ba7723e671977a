#pragma once

#include "vdblic/render/ray_caster.h"

namespace vdblic {

/// A ray to trace, in index space.
struct RayTask {
    Float4 entry, direction; ///< the direction has length 1; fourth lanes 0
    float view[3];           ///< direction in world space, of length 1
    float shift;             ///< of the samples, as a share of the step
    int samples;             ///< that fit between entry and exit
    int pixel;
    float entryDepth, depthPerVoxel; ///< along the view axis, in world space
};

/// Traces rays, eight in flight: a lane whose ray is done takes the next, so that lanes never idle in empty space.
class RayKernel {
  public:
    RayKernel(const TextureVolume& volume, const Look& look, const RayCastParams& params, const VisibleLeaves& visible);

    /// @param pixels receives red, green, blue, alpha of each task's pixel
    void trace(const RayTask* tasks, int count, glm::vec4* pixels) const;
    /// @param layers receives what each task's ray met, too
    void trace(const RayTask* tasks, int count, glm::vec4* pixels, PixelLayers* layers) const;

  private:
    struct Lanes;
    struct LayerSums;
    struct NoLayers;

    template<typename Layers>
    void traceWith(const RayTask* tasks, int count, glm::vec4* pixels, Layers layers) const;

    bool findSegment(Lanes& lanes, int lane) const;
    void refill(Lanes& lanes, int lane, const RayTask*& next, const RayTask* end) const;
    void sample(const Lanes& lanes, Float8* samples) const;
    template<typename Layers>
    void shade(Lanes& lanes, const Float8* samples, Layers& layers) const;

    const TextureVolume& mVolume;
    const Look& mLook;
    const VisibleLeaves& mVisible;
    float mStep, mLeastTransmittance, mMargin;
};

} // namespace vdblic
