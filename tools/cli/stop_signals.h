#pragma once

#include <istream>
#include <memory>

namespace vdblic::cli {

/// From here on SIGINT (Ctrl-C), SIGTERM and SIGHUP ask the job to stop; the same signal a second time ends the process
/// at once. A signal that the process was started to ignore (nohup) stays ignored.
void catchStopSignals();

/// The signal that asked to stop; 0 if none did.
[[nodiscard]] int stopSignal();

/// End the process as the signal would have: shells see the status 128 + its number.
[[noreturn]] void dieBy(int signal);

/// Standard input that ends when a stop is asked for, though whoever writes to it may not have come to an end.
[[nodiscard]] std::unique_ptr<std::istream> stoppableInput();

} // namespace vdblic::cli
