#pragma once

#include <string>

namespace vdblic::cli {

/// From here on, a crash, an abort or an endless loop while a thread has a file parsed (core/hazard.h) ends the process
/// with a message naming the file and the status of bad input. So does one for want of memory, wherever it is, with a
/// message that says so. Any other crash stays one.
///
/// Nothing is undone, and nothing has to be: outputs get their names when they are complete (io/atomic_file.h).
/// @param tool its name, for the message
void guardAgainstCrashes(const std::string& tool);

} // namespace vdblic::cli
