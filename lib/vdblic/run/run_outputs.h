#pragma once

#include "vdblic/io/sequence.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace vdblic {

struct AdvectParams;
struct AdvectPlan;

/// The number of a texture: the first frame keeps its number; substeps count on.
/// @param substep after the frame. @throws ParameterError if the number is too large
[[nodiscard]] std::int64_t textureNumber(std::int64_t first, std::int64_t frame, int substeps, int substep);

/// The output files of a run over a sequence: textures, a checkpoint beside them, and an optional report.
class RunOutputs {
  public:
    /// @param plan must outlive this. @throws ParameterError if the output is no pattern
    explicit RunOutputs(const AdvectPlan& plan);
    /// As above, with another checkpoint name.
    RunOutputs(const AdvectPlan& plan, std::filesystem::path checkpoint);

    /// Number the outputs from the sequence's first frame; later calls change nothing.
    void startAt(std::int64_t frame) { mFirst = mFirst.value_or(frame); }

    /// As textureNumber().
    [[nodiscard]] std::int64_t number(std::int64_t frame, int substep) const;
    [[nodiscard]] std::filesystem::path texture(std::int64_t frame, int substep) const
    {
        return mTextures.path(number(frame, substep));
    }
    [[nodiscard]] const std::filesystem::path& checkpoint() const { return mCheckpoint; }
    /// The lock file of a run while it writes: two runs would mix their outputs.
    [[nodiscard]] std::filesystem::path lock() const;
    /// A part of the checkpoint after `steps` steps.
    [[nodiscard]] std::filesystem::path checkpointPart(std::uint64_t steps, std::size_t part) const;
    /// The parts of the checkpoint on disk. @param but steps of the parts to leave out
    [[nodiscard]] std::vector<std::filesystem::path> checkpointParts(std::optional<std::uint64_t> but) const;

    /// Check that all outputs have different names and can be written.
    /// @param textures their number, 0 if it is not known
    /// @throws ParameterError, OutputError
    void check(std::size_t textures);

    /// Check that no texture of a frame and its substeps replaces an input: velocities, masks, and the noise.
    /// @throws ParameterError
    void checkInputs(const FrameFile& velocity) const;

  private:
    const AdvectPlan& mPlan;
    const AdvectParams& mParams;
    FramePattern mTextures;
    std::optional<std::int64_t> mFirst;
    std::filesystem::path mCheckpoint;
};

} // namespace vdblic
