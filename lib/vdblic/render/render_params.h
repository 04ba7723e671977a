#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/camera/camera_path.h"
#include "vdblic/cast/ground_side.h"
#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/image/image_file.h"
#include "vdblic/io/sequence.h"
#include "vdblic/look/look_params.h"
#include "vdblic/render/annotation_params.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <map>
#include <optional>
#include <string>

namespace vdblic {

/// Values that are given, by the keys of their parameters.
using Given = std::map<std::string, Words>;

inline constexpr const char* kSpeedGrid = "magnitude"; ///< colours where no grid is named

/// What parameters and plan of a picture have in common: values that no file and no look changes.
struct PictureSettings {
    std::string texture; ///< grid that holds the texture; empty: by the files' metadata, else `density`
    std::string region;  ///< FILE or FILE:GRID whose active voxels alone are shown; empty: all
    /// Lower and upper corner in world space: only voxels with their centre inside are shown.
    std::optional<std::array<double, 6>> regionBox{};
    /// Streaks as lines that are drawn in the texture: one file, or a pattern with the frames' numbers; empty: none
    std::string lines;
    std::string solid;                      ///< opaque body, as makeSolid() reads it (cast/solid.h); empty: none
    glm::dvec3 solidColor{0.7, 0.72, 0.75}; ///< as displayed
    bool earth = false;                     ///< whether the solid is the Earth, as EarthMap draws it
    GroundSide ground = GroundSide::kNone;  ///< where a plane takes the shadows of volume and solid
    /// Factors on the axes of world space for everything shown, such as 1 1 20 for weather. Camera and lights are in
    /// the stretched space, cuts and region in the grids' own.
    glm::dvec3 stretch{1};
    glm::ivec2 size{1024, 1024}; ///< width and height [pixels]
    int samples = 4;             ///< rays per pixel, see SampleSum
    CameraParams camera;
    CameraMotion motion;
    std::string cameraFile;   ///< JSON file that resolve() reads `motion.keys` from; empty: none
    std::string transferFile; ///< JSON file of a transfer function that resolve() reads on top of the look; empty: none
    RayCastParams rays;
    AnnotationParams annotations;

    /// Estimate of the memory that an image takes until it is written.
    [[nodiscard]] double imageBytes() const;
};

/// A picture as a user describes it. resolve() makes a PicturePlan of it (render_plan.h).
struct PictureParams : PictureSettings {
    std::string look;      ///< name of a look (lookPreset()); empty: by the textures
    Given lookOptions;     ///< parameters of LookParams and Background, on top of it and of the transfer function
    std::string by;        ///< grid that colour and opacity follow; empty: kSpeedGrid and the look's choice
    std::string colorBy;   ///< grid that colour follows; empty: by `by`
    std::string opacityBy; ///< grid that opacity follows; empty: by `by`

    /// @throws ParameterError
    void validate() const;
};

/// The outputs of a sequence of textures.
struct RenderOutputs {
    std::string images;           ///< one file or a pattern, .exr or .png; frame numbers are the input's; empty: none
    std::string film;             ///< .mp4 file of all frames; empty: none
    double framesPerSecond = 24;  ///< of the film
    std::string transferFunction; ///< JSON file for the transfer function of the pictures; empty: none
    std::string histogram;        ///< file for the histograms, .json or .png; empty: none
    bool skipExisting = false;    ///< leave existing images as they are
    ExrParams exr;

    /// @throws ParameterError
    void validate() const;
};

/// How a sequence of textures becomes a sequence of images, as a user describes it.
struct RenderParams {
    SequenceParams input;
    int substeps = 1;       ///< pictures in a frame, between which lines move on; its `frames` then select pictures
    bool keepGoing = false; ///< leave out frames that cannot be read, and fail at the end
    PictureParams picture;
    RenderOutputs outputs;

    /// The files that pictures are made of.
    [[nodiscard]] SequenceParams files() const;

    /// @throws ParameterError
    void validate() const;
};

[[nodiscard]] Parameters parametersOf(PictureParams& params);
[[nodiscard]] Parameters parametersOf(RenderParams& params);

} // namespace vdblic
