#pragma once

#include "vdblic/render/render_params.h"

#include <string>
#include <vector>

namespace vdblic {

/// The properties of a sequence's textures, from the headers of its files.
struct SequenceTraits {
    bool isSparse = false;              ///< whether inactive voxels are empty
    bool isNumbered = false;            ///< whether the number of frames is known: the input is a pattern
    std::string texture{};              ///< grid that holds the texture; empty: each file names its own
    std::vector<std::string> scalars{}; ///< float grids beside the texture, if they are known
};

/// The traits of the first file. An unreadable file is reported when its frame is rendered.
[[nodiscard]] SequenceTraits traitsOf(const SequenceParams& sequence);

/// The settings of pictures with every named file read: look, transfer function and key frames. chooseView() chooses
/// the values that depend on voxels: ranges, the opacity curve, the exposure, and unset members of the camera.
struct PicturePlan : PictureSettings {
    std::string lookName; ///< preset that `look` and `background` started from
    LookParams look;
    Background background;
    std::string colorBy; ///< grid whose values colour
    /// Grid that opacity follows: the first of these that the sequence has; empty: the one that colour follows.
    std::vector<std::string> opacityBy{};

    /// The plan's values as parameters, every one of them set.
    [[nodiscard]] PictureParams params() const;
};

/// The settings for the lines in a texture: its colours and light, and an opacity of their own, which follows the grid
/// that `opacity_by` names, else `q`, else `vorticity`, else the grid that colours. Regions do not cut lines.
[[nodiscard]] PicturePlan planOfLines(const PicturePlan& plan);

/// How a sequence of textures becomes a sequence of images.
struct RenderPlan {
    SequenceParams input; ///< the files
    int substeps = 1;
    std::string pictures{}; ///< list of numbers with several substeps; empty: all
    bool keepGoing = false;
    PicturePlan picture;
    RenderOutputs outputs;
    std::vector<std::string> choices{}; ///< each choice and its origin, for people
};

/// Read the files that parameters name, and choose settings by them and by the sequence's traits.
/// @throws ParameterError; InputError naming the file
[[nodiscard]] PicturePlan resolve(const PictureParams& params, const SequenceTraits& sequence);
[[nodiscard]] RenderPlan resolve(const RenderParams& params);

} // namespace vdblic
