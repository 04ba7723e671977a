#pragma once

#include "vdblic/core/paged_heap.h"
#include "vdblic/core/system_memory.h"

#include <cstddef>
#include <cstdint>
#include <mutex>

namespace vdblic {

/// Keeps the process's resident memory below a limit.
///
/// Runs leave the memory round and round in the order in which they lie in the file. The few that are in use come back
/// from the system's cache at once; the others were used longest ago, because work sweeps over all that there is.
class ResidentKeeper {
  public:
    ResidentKeeper(const PagedHeap& heap, std::uint64_t limit); ///< @param heap must outlive this

    void keep();
    /// Start a thread that keeps for ever, for what threads take without breathing. It takes no signals, and little of
    /// the limit on data by its stack.
    /// @return 0, or the system's reason why it cannot be started
    [[nodiscard]] int startThread();

  private:
    [[nodiscard]] bool isTooMuch(const ProcessMemory& now, std::uint64_t step) const;

    const PagedHeap& mHeap;
    std::uint64_t mMost, mStep, mCode;
    std::mutex mMutex;
    std::size_t mNext = 0; // run to let go
};

} // namespace vdblic
