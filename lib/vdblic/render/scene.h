#pragma once

#include "vdblic/render/render_sequence.h"

#include <openvdb/openvdb.h>

#include <memory>
#include <optional>
#include <span>

namespace vdblic {

/// A frame that was read.
struct LoadedTexture {
    FrameFile file;
    openvdb::FloatGrid::Ptr texture, magnitude;
    bool hasMagnitude;
    TextureVolume volume;
};

/// @throws InputError naming the file
[[nodiscard]] LoadedTexture loadFrame(const RenderParams& params, const FrameFile& frame);

/// What stays the same for the whole animation, once it is known what there is to see.
struct Scene {
    Look look;
    CameraPath cameras;
    double frameBytes; ///< about what a frame takes in memory
};

/// @param frames at least one, none empty
/// @param box    all that there will be to see, as far as is known
[[nodiscard]] Scene chooseScene(const RenderParams& params, std::span<const LoadedTexture> frames, const Corners& box,
                                const FrameSpan& span);

/// A scene, and the sequence's frame that was read to make it if that is its only one.
struct SequenceScene {
    Scene scene;
    std::shared_ptr<const LoadedTexture> onlyFrame;
};

/// The scene as the frames on disk give it, whichever are selected; nothing if none has an active voxel.
[[nodiscard]] std::optional<SequenceScene> sceneOfSequence(const RenderParams& params);

} // namespace vdblic
