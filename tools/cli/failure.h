#pragma once

#include "cli/console.h"
#include "cli/exit_status.h"

namespace vdblic::cli {

/// Print one message for the exception that a catch clause handles. Stopped and ClosedPipe, which end the run by a
/// signal, are thrown on.
/// @return the exit status that the error has
ExitStatus tellFailure(Console& console);

} // namespace vdblic::cli
