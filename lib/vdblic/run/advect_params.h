#pragma once

#include "vdblic/flow/flow_sequence_params.h"
#include "vdblic/methods/method_params.h"
#include "vdblic/run/texture_format.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdblic {

/// From a velocity sequence to a texture sequence.
struct AdvectParams : MethodParams {
    FlowSequenceParams flow;
    std::string output;          ///< pattern of the texture files
    std::optional<int> finish{}; ///< FinishParams::taps; nothing: finishTaps()
    std::string noise;           ///< FILE or FILE:GRID; empty: generated from the seed
    std::uint32_t seed = 1;      ///< of the generated noise
    /// Frames that the first one stands still for before it is written; nothing: the life span, 0 for LIC, 2 for
    /// streaks.
    std::optional<int> preroll;
    /// Frames on disk before the first of `flow.input.frames` that are computed but not written; nothing: up to twice
    /// the life span, 0 for LIC, the tail and 2 for streaks.
    std::optional<int> leadIn{};
    /// Displacement of the first frame's faster half (Displacements) that `flow.velocity.motion` is chosen for
    /// [voxels].
    std::optional<double> voxelsPerFrame{};
    int framesBefore = 0; ///< on disk, without a gap, before the first that is computed; set by withLeadIn()
    std::string textureName = "density";
    std::vector<std::string> derived{}; ///< further grids: of kDerivedNames, kVelocityName, kHitsGrid
    TextureFormat format{};
    std::string json{};                   ///< file for the RunReport; empty: none
    bool resume = false;                  ///< go on from the checkpoint that an earlier run left, if there is one
    bool restart = false;                 ///< remove that checkpoint and start from the beginning
    bool keepCheckpoint = false;          ///< leave a checkpoint when all is done, so that further frames can follow
    std::optional<int> checkpointEvery{}; ///< frames between checkpoints, 0 for none; nothing: CheckpointSchedule's

    void validate() const; ///< @throws ParameterError

    [[nodiscard]] const TextureMethod& method() const { return *texture.method; }
    [[nodiscard]] bool writesVelocity() const;                     ///< whether `derived` asks for the velocity
    [[nodiscard]] bool writesHits() const;                         ///< whether `derived` asks for the hits
    [[nodiscard]] std::vector<std::string> derivedScalars() const; ///< the other names of `derived`
    [[nodiscard]] int prerollFrames() const;                       ///< as given, else the default
    [[nodiscard]] std::uint64_t prerollSteps() const;              ///< with their substeps
    [[nodiscard]] int leadInFrames() const;                        ///< as given, else the default
    [[nodiscard]] int finishTaps() const;                          ///< as given, else the default
    [[nodiscard]] std::uint64_t
    warmUpSteps() const; ///< the steps of preroll and lead-in, whose textures are not written
    /// The number of intervals between frames that are computed after so many steps, without the preroll.
    [[nodiscard]] std::uint64_t framesDone(std::uint64_t steps) const;
    /// The number of textures to write that are computed after so many steps, those of preroll and lead-in included.
    [[nodiscard]] std::uint64_t texturesDone(std::uint64_t steps) const;
    /// The number of the next step, after so many, among its frame's substeps.
    [[nodiscard]] int substep(std::uint64_t steps) const;
    /// The number of textures of so many frames; 0 if that is not known. There is nothing between the last and a next.
    [[nodiscard]] std::size_t textures(std::size_t frames) const;
};
[[nodiscard]] Parameters parametersOf(AdvectParams& params);

} // namespace vdblic
