#pragma once

#include "vdblic/io/sequence.h"
#include "vdblic/render/camera_path.h"
#include "vdblic/render/look.h"
#include "vdblic/render/texture_volume.h"

#include <openvdb/openvdb.h>

#include <memory>
#include <optional>
#include <span>
#include <string>

namespace vdblic {

struct RenderParams;

/// A frame that was read.
struct LoadedTexture {
    FrameFile file;
    openvdb::FloatGrid::Ptr texture, color, opacity; ///< what colours and what makes opaque: two grids or one
    bool hasColor;                                   ///< if not, the texture colours
    std::string opacityBy;                           ///< name of the grid that makes opaque
    TextureVolume volume;
    std::optional<double> time; ///< of the file's metadata [s]
};

/// @throws InputError naming the file
[[nodiscard]] LoadedTexture loadFrame(const RenderParams& params, const FrameFile& frame);

/// What stays the same for the whole animation.
struct Scene {
    Look look;
    std::string opacityBy; ///< name of the grid that makes opaque, in every frame
    CameraPath cameras;
    Corners box;       ///< around all frames, as far as is known
    double frameBytes; ///< estimate of the memory that a frame takes
};

/// @param frames at least one, none empty
/// @param box    around all frames, as far as is known
/// @param steady whether every frame has these bounds: then what is visible of the frames fills the picture, else the
/// box
[[nodiscard]] Scene chooseScene(const RenderParams& params, std::span<const LoadedTexture> frames, const Corners& box,
                                bool steady, const FrameSpan& span);

/// A scene, and the frame that was read to make it if the sequence has no other.
struct SequenceScene {
    Scene scene;
    std::shared_ptr<const LoadedTexture> onlyFrame;
};

/// The scene of all frames on disk, whichever are selected; nothing if none has an active voxel.
[[nodiscard]] std::optional<SequenceScene> sceneOfSequence(const RenderParams& params);

} // namespace vdblic
