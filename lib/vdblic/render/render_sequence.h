#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/io/sequence.h"
#include "vdblic/render/camera.h"
#include "vdblic/render/image.h"
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
    std::string texture = "density"; ///< the grid that holds the texture
    std::string by = "magnitude";    ///< the grid that drives the transfer function
    std::string region;              ///< FILE or FILE:GRID whose active voxels are all that is shown; empty: everything
    glm::ivec2 size{1024, 1024};     ///< width and height [pixels]
    CameraParams camera;
    LookParams look;
    RayCastParams rays;
    Background background;

    /// @throws ParameterError
    void validate() const;
};

/// Render each frame of a texture sequence.
///
/// A file holds the texture and, on the same transform, the grid that drives the transfer function; without a grid
/// `magnitude` the texture itself is used in its place. Camera and look are chosen once and stay: from the first frame on disk, so that
/// machines which render some of the frames each make one animation; of paths on standard input, or if that frame is
/// empty, from the first frame that has an active voxel. Frames without one are all background.
/// @param lines where paths are read from if the input is `-`
/// @throws ParameterError, InputError naming the file, OutputError
void renderSequence(const RenderParams& params, std::istream& lines, Reporter& reporter);

} // namespace vdblic
