#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace vdblic::cli {

/// Do a job on independent frames of a sequence by several ranks. If a rank's job fails, the others finish theirs.
/// Collective.
///
/// @param frames   numbers of all; job() gets a list of a rank's
/// @param reporter of rank 0: it gets the messages and outputs of the other ranks when all have ended
/// @throws the exception of job() at the first rank that failed
void shareFrames(Exchange& exchange, const std::vector<std::int64_t>& frames, Reporter& reporter,
                 const std::function<void(const std::string& mine, Reporter& reporter)>& job);

} // namespace vdblic::cli
