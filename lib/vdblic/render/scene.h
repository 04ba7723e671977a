#pragma once

#include "vdblic/camera/camera_path.h"
#include "vdblic/io/sequence.h"
#include "vdblic/look/look.h"
#include "vdblic/render/annotation_texts.h"
#include "vdblic/volume/texture_volume.h"

#include <glm/vec3.hpp>
#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdblic {

class Exchange;
class LeafShare;
struct PicturePlan;
struct RenderPlan;
struct VdbFile;

/// A frame that was read.
struct LoadedTexture {
    FrameFile file;
    openvdb::FloatGrid::Ptr texture, color, opacity; ///< what colour and opacity follow: two grids or one
    bool hasColor;                                   ///< if not, the texture colours
    std::string opacityBy;                           ///< name of the grid that opacity follows
    TextureVolume volume;
    FrameClock clock;                                 ///< of the file's metadata
    std::string colorUnit, opacityUnit, lengthUnit{}; ///< of the scalars and of the world, as far as the file tells
    std::vector<std::string> kinds{};                 ///< as TransferParams has them, where sources colour
    bool isSparse = false;                            ///< whether inactive voxels are empty
    openvdb::FloatGrid::Ptr flowVoxels{}; ///< of a sparse texture: a grid whose active voxels are the flow's

    /// A grid whose active voxels are the flow's, fine enough for the faces of solids.
    [[nodiscard]] openvdb::FloatGrid::ConstPtr domain() const;

    /// One of the scalars on the texture's voxels. @throws InputError naming the file
    [[nodiscard]] openvdb::FloatGrid::ConstPtr onTexture(const openvdb::FloatGrid::Ptr& scalar) const;

    [[nodiscard]] double bytes() const; ///< estimate of the memory that it takes
};

/// Estimate of the memory that a voxel of a frame takes.
[[nodiscard]] double bytesPerVoxel(const PicturePlan& plan);

struct Scene;

/// Read a frame. Thread-safe.
/// @param scene that the frame is to be shown in, once it is chosen: opacity follows its grid, and leaves that its look
///              hides are not prepared
/// @param share the leaves that are read, of a frame that ranks share; null: all
/// @throws InputError naming the file
[[nodiscard]] LoadedTexture loadFrame(const PicturePlan& plan, const FrameFile& frame, const Scene* scene = nullptr,
                                      const LeafShare* share = nullptr);
/// The same for what a file holds. @param frame number and name, for masks and messages
[[nodiscard]] LoadedTexture loadFrame(const PicturePlan& plan, const VdbFile& file, const FrameFile& frame,
                                      const Scene* scene = nullptr, const LeafShare* share = nullptr);

/// What the look of a sequence is chosen from: samples of some of its frames.
struct LookBasis {
    VolumeSamples samples;
    double voxels = 0, volumeBytes = 0; ///< the most of a frame
    double narrowest = 0;               ///< the shortest side of a frame's voxels [voxels]; the most of a frame
    std::string opacityBy;              ///< name of the grid that opacity follows
    std::vector<std::string> kinds;     ///< of the first frame
    std::filesystem::path first;        ///< of the files
    std::int64_t lastFrame = 0;         ///< the largest number of a frame
    double longest = 0;                 ///< FrameClock::longest

    /// @param frame    not empty
    /// @param exchange of the ranks that share it: collective
    void add(const LoadedTexture& frame, Exchange& exchange);
    /// @throws ParameterError, InputError naming the first file
    [[nodiscard]] Look choose(const PicturePlan& plan) const;
};

/// What fills the picture: all that is visible of the frames and their solids, or the box around them if that is in the
/// picture; nothing if the camera leaves nothing to choose. @param exchange of the ranks that share the frames:
/// collective
[[nodiscard]] std::vector<glm::dvec3> sceneSubject(const PicturePlan& plan, const Look& look,
                                                   std::span<const std::shared_ptr<const LoadedTexture>> frames,
                                                   const Corners& box, Exchange& exchange);

/// What stays the same for the whole animation.
struct Scene {
    Look look;
    std::string opacityBy; ///< name of the grid that opacity follows, in every frame
    CameraPath cameras;
    Corners box;                ///< around all frames, as far as is known
    double frameBytes;          ///< estimate of the memory that a frame takes
    std::int64_t lastFrame = 0; ///< of those that the scene is chosen from, as LookBasis has it
    double longest = 0;
};

/// @param frames at least one, none empty
/// @param box    around all frames, as far as is known
/// @param exchange of the ranks that share the frames: collective
[[nodiscard]] Scene chooseScene(const PicturePlan& plan, std::span<const std::shared_ptr<const LoadedTexture>> frames,
                                const Corners& box, const FrameSpan& span, Exchange& exchange);

/// What the scene of a sequence is chosen from.
struct SceneSource {
    std::size_t frameCount; ///< on disk
    FrameSpan span;
    Corners box;                       ///< around all frames, stretched
    std::vector<FrameFile> lookFrames; ///< a few of them, the first one with an active voxel
};
/// By the headers of all files on disk, whichever are selected; nothing if none has an active voxel.
[[nodiscard]] std::optional<SceneSource> sceneSource(const SequenceParams& input, const PicturePlan& plan);

/// A scene, and the frame that was read to make it if the sequence has no other.
struct SequenceScene {
    Scene scene;
    std::shared_ptr<const LoadedTexture> onlyFrame; ///< null if ranks share it
};

/// The scene of sceneSource(); nothing if none of its frames has an active voxel.
/// @param exchange of ranks, each of which reads a part of the frames; collective
[[nodiscard]] std::optional<SequenceScene> sceneOfSequence(const RenderPlan& plan, Exchange& exchange);

} // namespace vdblic
