#pragma once

#include "vdblic/render/render_params.h"

#include <string>
#include <vector>

namespace vdblic {

/// What the headers of a sequence's files tell of its textures.
struct SequenceTraits {
    bool isSparse = false;              ///< whether inactive voxels are empty
    bool isNumbered = false;            ///< whether the number of frames is known: the input is a pattern
    std::string texture{};              ///< grid that holds the texture; empty: each file names its own
    std::vector<std::string> scalars{}; ///< float grids beside the texture, if they are known
};

/// The traits of files, by the first one. What cannot be read is reported at the frame's turn.
[[nodiscard]] SequenceTraits traitsOf(const SequenceParams& sequence);

/// How pictures are made, all files read that a user names for them: the look, transfer function and key frames in
/// effect. Only what depends on the voxels is still open, and is chosen by chooseView(): ranges, the opacity curve,
/// the exposure, and members of the camera that are not set.
struct PicturePlan : PictureSettings {
    std::string lookName; ///< of the look that `look` and `background` began with
    LookParams look;
    Background background;
    std::string colorBy; ///< grid whose values colour
    /// Grid that opacity follows: the first of these that the sequence has; empty: the one that colour follows.
    std::vector<std::string> opacityBy{};

    /// The plan's values as parameters, every one of them set.
    [[nodiscard]] PictureParams params() const;
};

/// How a sequence of textures becomes a sequence of images.
struct RenderPlan {
    SequenceParams input;
    bool keepGoing = false;
    PicturePlan picture;
    RenderOutputs outputs;
    std::vector<std::string> choices{}; ///< who chose what, for people
};

/// Read the files that parameters name, and choose by them and by what the sequence holds.
/// @throws ParameterError; InputError naming the file
[[nodiscard]] PicturePlan resolve(const PictureParams& params, const SequenceTraits& sequence);
[[nodiscard]] RenderPlan resolve(const RenderParams& params);

} // namespace vdblic
