#pragma once

#include "vdblic/camera/camera_path.h"
#include "vdblic/io/sequence.h"
#include "vdblic/look/look.h"
#include "vdblic/render/loaded_texture.h"
#include "vdblic/volume/texture_volume.h"

#include <glm/vec3.hpp>

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
class SolidMaker;
struct PicturePlan;
struct RenderPlan;

/// Samples of a few frames of a sequence, from which its look is chosen.
struct LookBasis {
    VolumeSamples samples;
    double volumeBytes = 0; ///< largest of the frames
    double thickness = 0;   ///< of a path through a frame [voxels, or tubes crossed]; largest of the frames
    bool ofLines = false;
    std::string opacityBy;          ///< name of the grid that opacity follows
    std::vector<std::string> kinds; ///< of the first frame
    std::filesystem::path first;    ///< of the files
    std::int64_t lastFrame = 0;     ///< largest frame number
    double longest = 0;             ///< FrameClock::longest

    /// @param frame    not empty
    /// @param exchange of the ranks that share it: collective
    void add(const LoadedTexture& frame, Exchange& exchange);
    /// @throws ParameterError, InputError naming the first file
    [[nodiscard]] Look choose(const PicturePlan& plan) const;

  private:
    void addVolume(const TextureVolume& volume, bool isSparse, Exchange& exchange);
    void addTubes(const Tubes& tubes);
};

/// The points that the picture frames: corners of the box if it or its axes are drawn, else of visible cells, with
/// solids and ground, and of the lines under their look. Empty for a perspective with a set eye.
/// @param exchange of the ranks that share the frames: collective
[[nodiscard]] std::vector<glm::dvec3> subjectOf(const PicturePlan& plan, const Look& look,
                                                std::span<const std::shared_ptr<const LoadedTexture>> frames,
                                                const Corners& box, SolidMaker& solids, Exchange& exchange,
                                                const Look* lines = nullptr);

/// Look, cameras and box common to all pictures of a sequence. Immutable, but for the solids.
struct View {
    Look look;
    std::string opacityBy; ///< name of the grid that opacity follows, in every frame
    CameraPath cameras;
    Corners box;                ///< around all known frames
    double frameBytes;          ///< estimated memory of a frame
    std::int64_t lastFrame = 0; ///< as in LookBasis
    double longest = 0;
    /// Of the lines in the voxels; nullopt if there are none.
    struct OfLines {
        Look look;
        std::string opacityBy;
    };
    std::optional<OfLines> lines{};
    std::shared_ptr<SolidMaker> solids{};
};

/// Looks of voxels and of the lines in them.
struct Looks {
    Look voxels;
    std::optional<View::OfLines> lines{};
};

/// Choose both, with one range of colours over the values of both. @param basis of the voxels  @param frames with lines
[[nodiscard]] Looks chooseLooks(const PicturePlan& plan, const LookBasis& basis,
                                std::span<const std::shared_ptr<const LoadedTexture>> frames);

/// @param frames at least one, none empty
/// @param box    around all known frames
/// @param exchange of the ranks that share the frames: collective
[[nodiscard]] View chooseView(const PicturePlan& plan, std::span<const std::shared_ptr<const LoadedTexture>> frames,
                              const Corners& box, const FrameSpan& span, Exchange& exchange);

/// The frames and the box from which the view of a sequence is chosen.
struct ViewSource {
    std::size_t frameCount; ///< on disk
    FrameSpan span;
    Corners box;                       ///< around all frames, stretched
    std::vector<FrameFile> lookFrames; ///< a few of them, the first one with an active voxel
};
/// From the headers of all files on disk, selected or not; nullopt if none has an active voxel.
[[nodiscard]] std::optional<ViewSource> viewSource(const SequenceParams& input, const PicturePlan& plan);

/// A view, and the frame that was read to make it if the sequence has no other.
struct SequenceView {
    View view;
    std::shared_ptr<const LoadedTexture> onlyFrame; ///< null if ranks share it
};

/// The view of viewSource(); nullopt if none of its frames has an active voxel.
/// @param exchange of ranks that each read a part of the frames; collective
[[nodiscard]] std::optional<SequenceView> viewOfSequence(const RenderPlan& plan, Exchange& exchange);

} // namespace vdblic
