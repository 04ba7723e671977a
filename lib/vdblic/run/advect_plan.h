#pragma once

#include "vdblic/io/sequence.h"
#include "vdblic/run/advect_params.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace vdblic {

/// A run in which every choice is made that takes no velocity: what the user said, and the frames and steps that follow
/// from it. The choices that take a velocity are made by the first frame (TextureRun).
struct AdvectPlan {
    const AdvectParams params;  ///< as given
    const SequenceParams input; ///< `params.flow.input` with the frames of the lead-in before the selected ones
    const int preroll;          ///< frames that the first one stands still for before it is written
    const int leadIn;           ///< frames that are computed before the selected ones and not written
    const int framesBefore;     ///< on disk, without a gap, before the lead-in
    const int finish;           ///< FinishParams::taps

    [[nodiscard]] const TextureMethod& method() const { return params.method(); }
    [[nodiscard]] int substeps() const { return params.texture.substeps; }

    [[nodiscard]] std::uint64_t prerollSteps() const; ///< with their substeps
    [[nodiscard]] std::uint64_t warmUpSteps() const;  ///< of preroll and lead-in, whose textures are not written
    /// The number of intervals between frames that are computed after so many steps, without the preroll.
    [[nodiscard]] std::uint64_t framesDone(std::uint64_t steps) const;
    /// The number of textures to write that are computed after so many steps, those of preroll and lead-in included.
    [[nodiscard]] std::uint64_t texturesDone(std::uint64_t steps) const;
    /// The number of the next step, after so many, among its frame's substeps.
    [[nodiscard]] int substep(std::uint64_t steps) const;
    /// The number of textures to write of so many frames, those of the lead-in included; 0 if that is not known. There
    /// is nothing between the last and a next.
    [[nodiscard]] std::size_t textures(std::size_t frames) const;
};

/// Make the choices of a run. A lead-in from the sequence's first frame on follows the preroll, so the textures are
/// those of a run over all frames; another one stands in for it.
/// @param params valid  @param around framesAround() the selected ones; of frames in memory none
[[nodiscard]] AdvectPlan resolve(AdvectParams params, const FramesAround& around = {});

/// The parameters with all choices in place of what is left open.
[[nodiscard]] AdvectParams chosenParams(const AdvectPlan& plan);

/// What is computed and not written, for the user; empty if there is no lead-in.
[[nodiscard]] std::string leadInText(const AdvectPlan& plan);

} // namespace vdblic
