#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/run/advect_params.h"

#include <iosfwd>

namespace vdblic {

/// Compute and write the texture of every frame (makeTextureFile()). Computing and writing overlap.
///
/// The run writes checkpoints beside the outputs, at intervals and when interrupted, and removes the last one when
/// complete (docs/advect.md). With `resume` a run continues from the checkpoint: its outputs equal those of an
/// uninterrupted run, and earlier ones are reported again as finished.
///
/// @param lines source of the paths if the input is `-`
/// @throws ParameterError, InputError, OutputError, Stopped; outputs written before stay
void advectSequence(const AdvectParams& params, std::istream& lines, Reporter& reporter);

/// The same by several ranks, to the same bytes (docs/distributed.md). Every rank reads the sequence; rank 0 writes.
/// @param lines    used at rank 0  @param reporter of this rank, silent except at rank 0
/// @param exchange with the other ranks, which call this with the same parameters
void advectSequence(const AdvectParams& params, std::istream& lines, Reporter& reporter, Exchange& exchange);

} // namespace vdblic
