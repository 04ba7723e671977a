#pragma once

#include "vdblic/core/crash_litter.h"

#include <filesystem>
#include <optional>

namespace vdblic {

/// A run's claim on a name: while it lives, no other process gets it. The system frees it when the process ends,
/// however it ends.
///
/// It is a lock (flock) on a small file, which names its holder and is removed with the claim; the next run takes
/// over the file of a killed one. On file systems without locks nothing is claimed. Where NFS is mounted without them
/// (`nolock`, `local_lock`), a claim holds on its host only.
class OutputLock {
  public:
    /// @param file that is locked  @param outputs named in the message
    /// @throws ParameterError naming the process that holds it; OutputError if the file cannot be made or is no lock
    OutputLock(std::filesystem::path file, const std::filesystem::path& outputs);
    ~OutputLock();
    OutputLock(const OutputLock&) = delete;
    OutputLock& operator=(const OutputLock&) = delete;

  private:
    std::filesystem::path mFile;
    int mDescriptor = -1;
    std::optional<CrashLitter> mLitter;
};

} // namespace vdblic
