#pragma once

namespace vdblic::cli {

/// Exit status of every tool (docs/formats.md). After a signal it is 128 plus the signal's number.
enum class ExitStatus { kDone = 0, kDiffers = 1, kUsage = 2, kBadInput = 3, kCannotWrite = 4, kBug = 5 };

} // namespace vdblic::cli
