#pragma once

#include "vdblic/cast/lanes.h"
#include "vdblic/field/vector.h"
#include "vdblic/look/shading.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <vector>

namespace vdblic {

/// The effect of lights on a colour.
struct Light {
    Float8 lit, white; ///< factor on the colour, and light added to it
};

/// The lights of a look, on eight surfaces at a time. Immutable; any number of threads may read.
class Lighting {
  public:
    /// @param shading must outlive this
    explicit Lighting(const Shading& shading) : mShading(shading)
    {
        for (const DirectionalLight& distant : shading.lights)
            mLights.emplace_back(glm::vec3(glm::normalize(distant.direction)), float(distant.intensity));
    }

    /// Direction of length 1, intensity.
    [[nodiscard]] const std::vector<glm::vec4>& lights() const { return mLights; }

    /// Schlick's approximation of cosine^shininess (Graphics Gems IV, 1994).
    [[nodiscard]] VDBLIC_INLINE Float8 highlight(Float8 cosine) const
    {
        const float power = mShading.shininess;
        const Float8 c = clamped(cosine);
        return c / (power - power * c + c + 1e-20f);
    }

    /// @param normal of length 1, towards the eye  @param view direction of the ray, of length 1
    [[nodiscard]] VDBLIC_INLINE Light surface(const Float8* normal, const Float8* view) const
    {
        const Float8 facing = -(normal[0] * view[0] + normal[1] * view[1] + normal[2] * view[2]);
        Float8 diffuse = facing * mShading.headLight;
        Float8 specular = highlight(2 * facing * facing - 1) * mShading.headLight;
        for (const glm::vec4& light : mLights) {
            const Float8 cosine = positive(normal[0] * light.x + normal[1] * light.y + normal[2] * light.z);
            const Float8 across = view[0] * light.x + view[1] * light.y + view[2] * light.z;
            diffuse += cosine * light.w;
            // Only a side that faces the light has a highlight.
            specular += (cosine > 0 ? highlight(2 * cosine * facing + across) : Float8{}) * light.w;
        }
        return {mShading.ambient + mShading.diffuse * diffuse, mShading.specular * specular};
    }

  private:
    const Shading& mShading;
    std::vector<glm::vec4> mLights;
};

} // namespace vdblic
