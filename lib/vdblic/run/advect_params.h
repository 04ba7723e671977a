#pragma once

#include "vdblic/flow/velocity_sequence_params.h"
#include "vdblic/methods/method_params.h"
#include "vdblic/run/texture_format.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdblic {

/// From a velocity sequence to a texture sequence.
struct AdvectParams : MethodParams {
    VelocitySequenceParams flow;
    std::string output;          ///< pattern of the texture files
    std::optional<int> finish{}; ///< FinishParams::taps; nothing: the method's
    std::string noise;           ///< FILE or FILE:GRID; empty: generated from the seed
    std::uint32_t seed = 1;      ///< of the generated noise
    /// Frames that the first one stands still for before it is written; nothing: TextureMethod::preroll.
    std::optional<int> preroll;
    /// Frames on disk before the first of `flow.input.frames` that are computed but not written, at most; nothing:
    /// TextureMethod::leadIn.
    std::optional<int> leadIn{};
    /// Displacement of the first frame's faster half (Displacements) that `flow.velocity.motion` is chosen for
    /// [voxels].
    std::optional<double> voxelsPerFrame{};
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
    [[nodiscard]] bool writesLines() const;                        ///< whether streaks are drawn as lines
    [[nodiscard]] std::vector<std::string> derivedScalars() const; ///< the other names of `derived`
};
[[nodiscard]] Parameters parametersOf(AdvectParams& params);

} // namespace vdblic
