#pragma once

#include "vdblic/io/sequence.h"
#include "vdblic/run/advect_params.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace vdblic {

/// A run's parameters, and all choices that need no velocity: frames and steps. The other choices depend on the first
/// frame (TextureRun).
struct AdvectPlan {
    const AdvectParams params;  ///< as given
    const SequenceParams input; ///< `params.flow.input` with the lead-in's frames before the selected ones
    const int preroll;          ///< frames during which the first one stands still before it is written
    const int leadIn;           ///< frames that are computed before the selected ones and not written
    const int framesBefore;     ///< on disk, without a gap, before the lead-in
    const int finish;           ///< FinishParams::taps

    [[nodiscard]] const TextureMethod& method() const { return params.method(); }
    [[nodiscard]] int substeps() const { return params.texture.substeps; }

    [[nodiscard]] std::uint64_t prerollSteps() const; ///< including their substeps
    [[nodiscard]] std::uint64_t warmUpSteps() const;  ///< of preroll and lead-in, without written textures
    /// The number of intervals between frames that are done after `steps` steps, without the preroll.
    [[nodiscard]] std::uint64_t framesDone(std::uint64_t steps) const;
    /// The number of written textures after `steps` steps, which include the steps of preroll and lead-in.
    [[nodiscard]] std::uint64_t texturesDone(std::uint64_t steps) const;
    /// The number of the next step, after `steps`, among its frame's substeps.
    [[nodiscard]] int substep(std::uint64_t steps) const;
    /// The number of written textures of `frames` frames, which include the lead-in's; 0 if unknown. The last frame
    /// has a single texture.
    [[nodiscard]] std::size_t textures(std::size_t frames) const;
};

/// Make the choices of a run. A lead-in that includes the sequence's first frame follows the preroll, so the textures
/// are those of a run over all frames; any other replaces the preroll.
/// @param params valid  @param around framesAround() the selected ones; empty for frames in memory
[[nodiscard]] AdvectPlan resolve(AdvectParams params, const FramesAround& around = {});

/// The parameters with all choices filled in.
[[nodiscard]] AdvectParams chosenParams(const AdvectPlan& plan);

/// The frames computed but not written, for the user; empty without a lead-in.
[[nodiscard]] std::string leadInText(const AdvectPlan& plan);

} // namespace vdblic
