#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <cstdint>
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

/// The surface behind each pixel's centre, without the volume.
struct SurfacePicture {
    std::vector<float> depths;      ///< along the view axis from the eye's plane [world]; infinite where there is none
    std::vector<glm::vec4> colors;  ///< linear light, lit; premultiplied by alpha
    std::vector<glm::vec3> normals; ///< world space, of length 1
};

/// The solid and the ground that each pixel's ray meets first; nullopt if there is neither. Thread-safe.
/// @param box of the volume in front  @param ray index among each pixel's rays
/// @param only by pixel: whether its surface is wanted; null: all are
[[nodiscard]] std::optional<SurfacePicture> castSurfaces(const Scenery& scenery, const PlacedBox& box, const Look& look,
                                                         const Camera& camera, int ray, const std::uint8_t* only);

/// Blend surfaces behind the cast pixels of an image.
/// @param only by pixel: whether it was cast; null: all were
void addBehind(const SurfacePicture& surfaces, const std::uint8_t* only, Image& image);

} // namespace vdblic
