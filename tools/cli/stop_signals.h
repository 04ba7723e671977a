#pragma once

#include <istream>
#include <memory>

namespace vdblic::cli {

/// From here on SIGINT (Ctrl-C), SIGTERM, SIGHUP and SIGUSR1 request the job to stop. The same signal a second time
/// ends the process at once. A signal that was ignored at the start (nohup) stays ignored.
void catchStopSignals();

/// The signal that requested a stop; 0 if none did.
[[nodiscard]] int stopSignal();

/// End the process by the signal, so that shells see the status 128 + its number.
[[noreturn]] void dieBy(int signal);

/// Standard input that ends when a stop is requested, even if its writer has not closed it.
[[nodiscard]] std::unique_ptr<std::istream> stoppableInput();

} // namespace vdblic::cli
