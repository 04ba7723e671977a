#pragma once

#include "vdblic/camera/camera.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <optional>

namespace vdblic {

/// Where a pixel's ray passes through the lens, in the unit disc: a low-discrepancy sequence over the pixel's rays
/// (Halton 1960, bases 3 and 5), moved by blue noise from pixel to pixel and mapped to the disc with equal areas
/// (Shirley & Chiu 1997).
/// @param ray index among the pixel's rays
[[nodiscard]] glm::dvec2 lensPoint(int x, int y, int ray);

/// The rays through the pixels' centres in world space. A direction's component along the view axis is 1. Immutable.
class PixelRays {
  public:
    /// @param ray index among each pixel's rays
    PixelRays(const Camera& camera, int ray) : mRays(camera.rays()), mLens(camera.lens()), mRay(ray) {}

    struct Line {
        glm::dvec3 origin, direction;
    };
    [[nodiscard]] Line at(int x, int y) const
    {
        const glm::dvec2 pixel(x + 0.5, y + 0.5);
        Line line{mRays.origin(pixel), mRays.direction(pixel)};
        if (mLens) {
            const glm::dvec2 point = lensPoint(x, y, mRay);
            const glm::dvec3 aside = mLens->right * point.x + mLens->up * point.y;
            line.origin += aside;
            line.direction -= aside * mLens->perDepth;
        }
        return line;
    }

  private:
    PictureRays mRays;
    std::optional<Lens> mLens;
    int mRay;
};

} // namespace vdblic
