#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/run/advect_params.h"

namespace vdblic {

/// The parameters of a run that begins with earlier frames on disk, which are computed but not written: as many as the
/// parameters ask for and there are.
///
/// In the result `input.frames` includes those frames and `leadIn` is their number. A lead-in from the sequence's first
/// frame on follows the preroll, so the textures are those of a run over all frames; another one stands in for it.
/// @throws InputError, ParameterError
[[nodiscard]] AdvectParams withLeadIn(AdvectParams params, Reporter& reporter);

} // namespace vdblic
