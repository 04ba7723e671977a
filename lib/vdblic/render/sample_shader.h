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

    struct FaceLight {
        float lit, white; ///< RayTask's kFaceLit and kFaceWhite
    };
    /// How a plane face shows that is seen along a direction, both of length 1 in world space.
    [[nodiscard]] FaceLight lightFace(const glm::dvec3& normal, const glm::dvec3& view) const;

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
