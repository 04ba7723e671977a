#pragma once

#include "vdblic/cast/depth_cue.h"
#include "vdblic/cast/lighting.h"
#include "vdblic/cast/ray_task.h"
#include "vdblic/field/vector.h"

#include <glm/vec3.hpp>

namespace vdblic {

class Camera;
class LightGrid;
class ShadeQueue;
class TextureVolume;
struct Look;
struct RayCastParams;

/// Light and colour of samples, eight at a time. Thread-safe.
class SampleShader {
  public:
    /// @param origin of the rays' index space  @param light shadows, or null
    SampleShader(const TextureVolume& volume, const Look& look, const Camera& camera, const RayCastParams& params,
                 const glm::vec3& origin = glm::vec3(0), const LightGrid* light = nullptr);

    /// Shade the first eight samples of a queue and add them to their rays' sums, in order.
    void shade(const ShadeQueue& queue, const RayTask* tasks, RaySum* sums) const;

    /// Light the faces where rays enter.
    /// @param outward their normals, of length 1 in world space, fourth lane 1; all 0 for a ray that enters through
    /// none
    void lightFaces(const Float4* outward, RayTask* tasks, int count) const;

  private:
    Light lightLine(const ShadeQueue& queue, const Float8* view) const;
    Float8 arrivingLight(const ShadeQueue& queue, const RayTask* tasks) const;
    void addLayers(const ShadeQueue& queue, const Float8* normal, Float8 surface, Float8 depth, RaySum* sums) const;

    const TextureVolume& mVolume;
    const Look& mLook;
    float mStep;
    bool mLayers, mIsCubic;
    DepthCue mCue;
    glm::vec3 mOrigin;
    const LightGrid* mLightGrid;
    Lighting mLighting;
};

} // namespace vdblic
