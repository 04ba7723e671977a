#pragma once

#include "cli/console.h"
#include "cli/exit_status.h"

namespace vdblic::cli {

/// Tell the error that is being handled, in a catch clause: one message for any exception but for those that end the
/// run by a signal, which it throws on (Stopped, ClosedPipe).
/// @return the exit status that the error has
ExitStatus tellFailure(Console& console);

} // namespace vdblic::cli
