#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/camera/camera_path.h"
#include "vdblic/cast/ground_params.h"
#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/solid_params.h"
#include "vdblic/image/image_file.h"
#include "vdblic/io/sequence.h"
#include "vdblic/look/look_params.h"
#include "vdblic/render/annotation_params.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace vdblic {

/// How a sequence of textures becomes a sequence of images.
struct RenderParams {
    SequenceParams input;
    bool skipExisting = false;   ///< leave existing outputs as they are
    bool keepGoing = false;      ///< leave out frames that cannot be read, and fail at the end
    std::string output;          ///< one file or a pattern, .exr or .png; frame numbers are the input's
    std::string film;            ///< .mp4 file of all frames; empty: none
    double framesPerSecond = 24; ///< of the film
    AnnotationParams annotations;
    std::string transferOut{};         ///< JSON file for the transfer function that the frames are rendered with
    std::string histogram;             ///< file for the histograms, .json or .png; empty: none
    std::string texture;               ///< grid that holds the texture; empty: by the files' metadata, else `density`
    std::string colorBy = "magnitude"; ///< grid whose values colour
    /// Grid that opacity follows: the first of these that the sequence has; empty: the one that colour follows.
    std::vector<std::string> opacityBy{};
    std::string region; ///< FILE or FILE:GRID whose active voxels alone are shown; empty: all
    /// Lower and upper corner in world space: only voxels with their centre inside are shown.
    std::optional<std::array<double, 6>> regionBox{};
    SolidParams solid;
    GroundParams ground{};
    /// Factors on the axes of world space for all that is shown, such as 1 1 20 for weather. Camera and lights are in
    /// the stretched space, cuts and region in the grids' own.
    glm::dvec3 stretch{1};
    glm::ivec2 size{1024, 1024}; ///< width and height [pixels]
    double scale = 1;            ///< factor on the size, for previews
    int samples = 1;             ///< rays per pixel
    CameraParams camera;
    CameraMotion motion;
    std::string lookName = "flow"; ///< that `look`, `background` and `opacityBy` started from
    LookParams look;
    RayCastParams rays;
    Background background;
    ExrParams exr;

    /// The size times the scale, at least one pixel a side.
    [[nodiscard]] glm::ivec2 scaledSize() const;
    /// Estimate of the memory that an image takes until it is written.
    [[nodiscard]] double imageBytes() const;
    /// @throws ParameterError
    void validate() const;
    /// As validate(), but for outputs. @throws ParameterError
    void validatePicture() const;
};

/// As the look of textures has it for which none is asked, sparse ones or others (defaultLookName()).
[[nodiscard]] RenderParams defaultRenderParams(bool isSparse = false);
/// Those that determine a picture: not the files that it comes from and goes to. The look comes first, so that others
/// are set on top of it.
[[nodiscard]] Parameters pictureParametersOf(RenderParams& params);
[[nodiscard]] Parameters parametersOf(RenderParams& params);

} // namespace vdblic
