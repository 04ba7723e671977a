#pragma once

#include "vdblic/flow/velocity_sequence_params.h"
#include "vdblic/methods/method_params.h"
#include "vdblic/run/texture_format.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdblic {

/// Parameters from a velocity sequence to a texture sequence.
struct AdvectParams : MethodParams {
    VelocitySequenceParams flow;
    std::string output;          ///< pattern of the texture files
    std::optional<int> finish{}; ///< FinishParams::taps; nothing: the method's
    std::string noise;           ///< FILE or FILE:GRID; empty: generated from the seed
    std::uint32_t seed = 1;      ///< of the generated noise
    /// Frames during which the first one stands still before it is written; nothing: TextureMethod::preroll.
    std::optional<int> preroll;
    /// The most frames on disk before the first of `flow.input.frames` that are computed but not written; nothing:
    /// TextureMethod::leadIn.
    std::optional<int> leadIn{};
    /// Target displacement of the first frame's faster half (Displacements) [voxels], which sets
    /// `flow.velocity.motion`.
    std::optional<double> voxelsPerFrame{};
    std::string textureName = "density";
    std::vector<std::string> derived{}; ///< further grids: of kDerivedNames, kVelocityName, kHitsGrid
    TextureFormat format{};
    std::string json{};                   ///< file for the RunReport; empty: none
    bool resume = false;                  ///< continue from the checkpoint of an earlier run, if any
    bool restart = false;                 ///< remove that checkpoint and start from the beginning
    bool keepCheckpoint = false;          ///< keep a checkpoint at the end, so that further frames can follow
    std::optional<int> checkpointEvery{}; ///< frames between checkpoints, 0 for none; nothing: CheckpointSchedule's

    void validate() const; ///< @throws ParameterError

    [[nodiscard]] const TextureMethod& method() const { return *texture.method; }
    [[nodiscard]] bool writesVelocity() const;                     ///< whether `derived` asks for the velocity
    [[nodiscard]] bool writesHits() const;                         ///< whether `derived` asks for the hits
    [[nodiscard]] bool writesLines() const;                        ///< whether streaks are drawn as lines
    [[nodiscard]] std::vector<std::string> derivedScalars() const; ///< the other names of `derived`
};
[[nodiscard]] Parameters parametersOf(AdvectParams& params);

} // namespace vdblic
