#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/io/sequence.h"

#include <functional>

namespace vdblic::cli {

/// Do a job on independent frames of a sequence by several ranks. If a rank's job fails, the others finish theirs.
/// Collective.
///
/// @param input    whole; job() gets a rank's frames
/// @param reporter of rank 0: it gets the messages and outputs of the other ranks when all have ended
/// @throws the exception of job() at the first rank that failed; ParameterError if the input is standard input
void shareFrames(Exchange& exchange, const SequenceParams& input, Reporter& reporter,
                 const std::function<void(const SequenceParams& input, Reporter& reporter)>& job);

} // namespace vdblic::cli
