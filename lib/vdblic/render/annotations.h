#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/image/image.h"
#include "vdblic/render/annotation_params.h"
#include "vdblic/render/annotation_texts.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace vdblic {

struct Look;

/// The content of annotations.
struct AnnotationContent {
    Corners box;         ///< of the domain, in the picture's world
    glm::dvec3 stretch;  ///< of that world
    std::string colorBy; ///< names of the grids
    std::string opacityBy;
    std::int64_t frame;
    FrameClock clock{};
    std::int64_t lastFrame = 0;             ///< of the sequence
    std::string colorUnit{}, opacityUnit{}; ///< of the grids; empty: unknown
    std::string lengthUnit{};               ///< of the world, the same
    bool isGeographic = false;              ///< whether x, y and z are east, north and up
    /// Of the lines in a volume.
    struct OfLines {
        const Look* look = nullptr; ///< null: there are none
        std::string opacityBy{}, opacityUnit{};
    };
    OfLines lines{};
};

/// The points of a picture's subject, and room beside them for axes and colour bars.
/// @param view of the box; a camera that a user placed has no room to give
[[nodiscard]] std::vector<glm::dvec3> withRoom(std::vector<glm::dvec3> subject, const AnnotationParams& params,
                                               const Camera& view);

/// Draw annotations as a layer of their own, Image::annotations, and leave the other layers as they are. The size of
/// text and lines follows the picture's height.
/// @param background display (sRGB) values; annotations are light on a dark one and dark on a light one
void annotate(Image& image, const AnnotationParams& params, const AnnotationContent& content, const Look& look,
              const Camera& camera, const glm::dvec3& background);

} // namespace vdblic
