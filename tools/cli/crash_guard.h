#pragma once

#include <string>

namespace vdblic::cli {

/// Handle crashes from here on. A crash, an abort or an endless loop while a thread parses a file (core/hazard.h) ends
/// the process with a message that names the file, and with the status of bad input. A crash for lack of memory,
/// anywhere, ends it with a message that says so. Any other crash stays one.
///
/// Nothing has to be undone: an output gets its name once it is complete (io/atomic_file.h).
/// @param tool its name, for the message
void guardAgainstCrashes(const std::string& tool);

} // namespace vdblic::cli
