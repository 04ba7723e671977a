#pragma once

#include "vdblic/cast/depth_cue.h"
#include "vdblic/cast/pixel_rays.h"

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <openvdb/tools/RayIntersector.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace vdblic {

class Camera;
class Ground;
class LightGrid;
class PlacedBox;
class TubeTree;
struct Image;
struct Look;
struct PixelLayers;
struct Solid;

/// What a picture shows beside its volume or tubes.
struct Scenery {
    const Solid* solid = nullptr;
    glm::vec3 solidColor{0}; ///< linear light
    const LightGrid* light = nullptr;
    const Ground* ground = nullptr;
    const TubeTree* tubes = nullptr; ///< in a volume
    const Look* tubesLook = nullptr; ///< theirs
};

/// What a ray meets behind a volume or tubes.
struct Surface {
    float depth = std::numeric_limits<float>::infinity(); ///< along the view axis from the eye's plane [world]
    glm::vec4 color{0};                                   ///< linear light, lit; premultiplied by alpha
    glm::vec3 normal{0};                                  ///< world space, of length 1
};

/// What a gap shows. @param surface premultiplied by alpha
[[nodiscard]] inline glm::vec3 seenThrough(const glm::vec4& surface, const glm::vec3& background)
{
    return glm::vec3(surface) + background * (1 - surface.a);
}

/// Finds the solid or the ground that rays meet first, and lights them by the look's lights. A copy may be used by one
/// thread at a time.
class SurfaceCaster {
  public:
    /// @param scenery, look must outlive this and its copies  @param box of the volume or the tubes in front
    SurfaceCaster(const Scenery& scenery, const PlacedBox& box, const Look& look, const Camera& camera);

    /// @param ray of a pixel in a row of the picture
    [[nodiscard]] Surface at(const PixelRays::Line& ray, int row);

  private:
    [[nodiscard]] std::optional<Surface> solidAt(const PixelRays::Line& ray, int row);
    [[nodiscard]] std::optional<Surface> groundAt(const PixelRays::Line& ray, int row) const;

    const Scenery& mScenery;
    const PlacedBox& mBox;
    const Camera& mCamera;
    const Look& mLook;
    DepthCue mCue;
    std::vector<glm::vec3> mBackground; // by row
    glm::dvec3 mTowardsLight;
    glm::vec3 mSolidColor; // before the exposure
    float mExposure;
    std::optional<openvdb::tools::LevelSetRayIntersector<openvdb::FloatGrid>> mSolid; // has a cache
    glm::dvec3 mMiddle{};                                                             // of a ball around the solid
    double mSquare = 0;                                                               // of its radius
};

/// The surface behind each pixel's centre, without the volume.
struct SurfacePicture {
    std::vector<float> depths;      ///< along the view axis from the eye's plane [world]; infinite where there is none
    std::vector<glm::vec4> colors;  ///< linear light, lit; premultiplied by alpha
    std::vector<glm::vec3> normals; ///< world space, of length 1

    [[nodiscard]] Surface at(std::size_t pixel) const { return {depths[pixel], colors[pixel], normals[pixel]}; }
};

/// The solid and the ground that each pixel's ray meets first; nullopt if there is neither. Thread-safe.
/// @param box of the volume in front  @param ray index among each pixel's rays
/// @param only by pixel: whether its surface is wanted; null: all are
[[nodiscard]] std::optional<SurfacePicture> castSurfaces(const Scenery& scenery, const PlacedBox& box, const Look& look,
                                                         const Camera& camera, int ray, const std::uint8_t* only);

/// Blend a surface behind a pixel. @param layers of the pixel; or null
void addBehind(const Surface& surface, glm::vec4& pixel, PixelLayers* layers);
/// The same for the cast pixels of an image.
/// @param only by pixel: whether it was cast; null: all were
void addBehind(const SurfacePicture& surfaces, const std::uint8_t* only, Image& image);

} // namespace vdblic
