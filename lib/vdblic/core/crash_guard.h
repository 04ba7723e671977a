#pragma once

#include <string>

namespace vdblic {

/// The exit statuses of a process after a crash.
struct CrashStatuses {
    int badInput = 3, cannotWrite = 4;
};

/// For programs that end with a message: handle crashes from here on. A crash, an abort or an endless loop while a
/// thread parses a file (core/hazard.h) ends the process with a message that names the file, and with the status of bad
/// input; so does a stack that overflows there, in any thread. A crash for lack of memory, anywhere, ends it with a
/// message that says so, and one for a scratch file that the disk fails with the status of an output. Any other crash
/// stays one.
///
/// Nothing has to be undone: an output gets its name once it is complete (io/atomic_file.h).
/// @param program its name, for the message
void guardAgainstCrashes(const std::string& program, const CrashStatuses& statuses = {});

} // namespace vdblic
