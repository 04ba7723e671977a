#pragma once

#include <atomic>
#include <cstddef>

namespace vdblic::paging {

/// \file
/// The library announces its need of memory here. A program may then place memory in a scratch file
/// (core/scratch_memory.h; docs/architecture.md, "Larger than memory"): results stay the same. In other programs these
/// functions do nothing.

/// A program's placement of memory: one per process, like its operator new. Thread-safe.
class Memory {
  public:
    Memory() = default;
    Memory(const Memory&) = delete;
    Memory& operator=(const Memory&) = delete;
    virtual ~Memory() = default;

    virtual bool makeRoom(double bytes) = 0;
    virtual void expectFiles(double bytes) = 0;
    [[nodiscard]] virtual bool mayHold(double bytes) const = 0;
    virtual void breathe(std::size_t bytes) = 0;
    [[nodiscard]] virtual const char* problem() const noexcept = 0;
    [[nodiscard]] virtual const char* failureAt(const void* address) const noexcept = 0;
};

/// Set it once, before the work begins. @param memory must live as long as the process
void setMemory(Memory& memory);

namespace detail {
extern std::atomic<Memory*> gMemory;
} // namespace detail

/// Make room for a run's peak memory: if it nears or exceeds the limit, start a scratch file and allocate its blocks,
/// so that the disk cannot fill up later.
/// @param bytes peak of the run  @return whether memory is paged and the scratch file holds `bytes`
/// @throws OutputError, naming the folder and the reason, if the scratch file cannot be made or grow so far
bool makeRoom(double bytes);

/// Start paging, without reserving disk space, if files of `bytes` in memory need it.
/// @throws OutputError if no scratch file can be made
void expectFiles(double bytes);

/// Whether memory plus a scratch file in the disk's free space hold `bytes`. False without a scratch file.
[[nodiscard]] bool mayHold(double bytes);

/// Called by threads that sweep much memory, before they touch `bytes` more: a thread that outruns eviction waits here.
inline void breathe(std::size_t bytes)
{
    Memory* const memory = detail::gMemory.load(std::memory_order_acquire);
    if (__builtin_expect(memory != nullptr, 0)) memory->breathe(bytes);
}
inline constexpr std::size_t kLeafBytes = 16384;    ///< touched per leaf, about
inline constexpr std::size_t kPointBytes = 1 << 19; ///< touched by a lookup far from the last one

/// Why the scratch file could not grow, as a message; null if it could. May be called in a signal handler.
[[nodiscard]] const char* problem() noexcept;
/// The message for a bus error at an address: the disk fails a page of the scratch file. Null if the address
/// is not in it. May be called in a signal handler.
[[nodiscard]] const char* failureAt(const void* address) noexcept;
/// @throws OutputError with problem() if there is one
void checkScratch();

} // namespace vdblic::paging
