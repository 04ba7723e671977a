#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/io/sequence.h"
#include "vdblic/render/camera_path.h"
#include "vdblic/render/image_file.h"
#include "vdblic/render/look.h"
#include "vdblic/render/ray_caster.h"

#include <iosfwd>
#include <string>

namespace vdblic {

/// How a sequence of textures becomes a sequence of images.
struct RenderParams {
    SequenceParams input;
    bool skipExisting = false;       ///< leave outputs that are there as they are
    std::string output;              ///< one file or a pattern, .exr or .png; frame numbers are the input's
    std::string histogram;           ///< file for the histograms, .json or .png; empty: none
    std::string texture = "density"; ///< the grid that holds the texture
    std::string by = "magnitude";    ///< the grid that drives the transfer function
    std::string region;              ///< FILE or FILE:GRID whose active voxels are all that is shown; empty: everything
    /// Factors on the world's axes for all that is shown, such as 1 1 20 for weather; camera and lights stand in the
    /// stretched space, cuts and region in the grids' own.
    glm::dvec3 stretch{1};
    glm::ivec2 size{1024, 1024}; ///< width and height [pixels]
    double scale = 1;            ///< factor on the size, for previews
    int samples = 1;             ///< rays to a pixel
    CameraParams camera;
    CameraMotion motion;
    LookParams look;
    RayCastParams rays;
    Background background;
    ExrParams exr;

    /// The size of the images that are made, at least one pixel.
    [[nodiscard]] glm::ivec2 scaledSize() const;
    /// About what one of them takes in memory until it is written.
    [[nodiscard]] double imageBytes() const;
    /// @throws ParameterError
    void validate() const;
};

/// Render each frame of a texture sequence, as many side by side as there are threads and memory holds.
///
/// A file holds the texture and, on the same transform, the grid that drives the transfer function; without a grid
/// `magnitude` the texture itself is used in its place. What is chosen for the user is chosen once and stays: the
/// camera such that all of the frames on disk is seen, the look from a few of them, whichever are selected, so that
/// machines which render some of the frames each make one animation. Of paths on standard input the first with an
/// active voxel decides. Frames without one are all background.
///
/// The histograms are those of all frames that were rendered; with no output they are all that is made.
/// @param lines where paths are read from if the input is `-`
/// @throws ParameterError, InputError naming the file, OutputError; images finished before stay
void renderSequence(const RenderParams& params, std::istream& lines, Reporter& reporter);

} // namespace vdblic
