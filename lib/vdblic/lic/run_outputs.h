#pragma once

#include "vdblic/io/sequence.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace vdblic {

struct AdvectParams;

/// The files that a run over a sequence writes: textures, a checkpoint beside them, and a report if one is wanted.
class RunOutputs {
  public:
    /// @param params must outlive this. @throws ParameterError if the output is no pattern
    explicit RunOutputs(const AdvectParams& params);

    [[nodiscard]] std::filesystem::path texture(std::int64_t frame) const { return mTextures.path(frame); }
    [[nodiscard]] const std::filesystem::path& checkpoint() const { return mCheckpoint; }

    /// Check that all outputs have different names and that the report can be written.
    /// @param frames number of input frames, 0 if it is not known
    /// @throws ParameterError, OutputError
    void check(std::size_t frames) const;

    /// Check that no output replaces what a frame is computed from: its velocity, its mask, and the noise.
    /// @throws ParameterError
    void checkInputs(const FrameFile& velocity) const;

  private:
    const AdvectParams& mParams;
    FramePattern mTextures;
    std::filesystem::path mCheckpoint;
};

} // namespace vdblic
