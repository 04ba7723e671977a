#pragma once

#include "vdblic/render/ray_caster.h"
#include "vdblic/render/shade_queue.h"

namespace vdblic {

/// Light and colour of samples, eight at a time.
class SampleShader {
  public:
    SampleShader(const TextureVolume& volume, const Look& look, const Camera& camera, const RayCastParams& params);

    /// Shade the first eight samples of a queue and add them to their rays' sums, in order. Those beyond its count must
    /// have weight 0.
    void shade(const ShadeQueue& queue, const RayTask* tasks, RaySum* sums) const;

    /// Light the faces through which rays come in.
    /// @param outward their normals, of length 1 in world space, with 1 behind; 0 for rays that come in through none
    void lightFaces(const Float4* outward, RayTask* tasks, int count) const;

  private:
    struct Light {
        Float8 lit, white; // share of the colour that is seen, and light added to it
    };
    Light lightSurface(const Float8* normal, const Float8* view) const;
    Light lightLine(const ShadeQueue& queue, const Float8* view) const;
    Float8 highlight(Float8 cosine) const;
    void addLayers(const ShadeQueue& queue, const Float8* normal, Float8 surface, Float8 depth, RaySum* sums) const;

    const TextureVolume& mVolume;
    const Look& mLook;
    float mStep;
    bool mLayers;
    float mNearest, mCuePerDepth;
    std::vector<glm::vec4> mLights; // direction of length 1, intensity
};

} // namespace vdblic
