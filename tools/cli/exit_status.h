#pragma once

namespace vdblic::cli {

/// What a tool's process returns; the same for every tool (docs/survival.md). A signal adds its number to 128.
enum class ExitStatus { kDone = 0, kDiffers = 1, kUsage = 2, kBadInput = 3, kCannotWrite = 4, kBug = 5 };

} // namespace vdblic::cli
