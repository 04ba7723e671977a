#pragma once

#include <string>

namespace vdblic {

/// The exit statuses of a process after a crash.
struct CrashStatuses {
    int badInput = 3, cannotWrite = 4;
};

/// Install the process's crash handlers. A crash, abort, stack overflow or endless loop while a thread parses a file
/// (core/hazard.h) ends the process with a message that names the file, and with the status of bad input. A crash for
/// lack of memory or threads, anywhere, ends it with a message that says so and the same status; a failure of the
/// scratch file's disk ends it with the status of an output. Other crashes stay crashes.
///
/// No cleanup is needed: outputs get their names only when complete (io/atomic_file.h).
/// @param program its name, for the message
void guardAgainstCrashes(const std::string& program, const CrashStatuses& statuses = {});

} // namespace vdblic
