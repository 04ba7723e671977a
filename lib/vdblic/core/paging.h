#pragma once

#include <atomic>
#include <cstddef>

namespace vdblic::paging {

/// \file
/// How the library announces its need of memory to a program that can place memory elsewhere: in a scratch
/// file (core/scratch_memory.h; docs/architecture.md, "Larger than memory"). Contents of memory, and so
/// all results, are the same. In other programs all of this does nothing.

/// Where a program's memory lies. Like its operator new it is of the process, not of an object. Thread-safe.
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

/// Make room for a run's peak memory: begin a scratch file if that is near or above the limit. The file's blocks are
/// then allocated on disk, so that the disk cannot become full later.
/// @param bytes that the run takes
/// @return whether memory is paged now and the scratch file holds as much
/// @throws OutputError, naming the folder and the reason, if the scratch file cannot be made or grow so far
bool makeRoom(double bytes);

/// Begin paging, without room on the disk yet, if a job that reads files of so much memory would need it.
/// @throws OutputError if no scratch file can be made
void expectFiles(double bytes);

/// Whether memory and a scratch file in the free space of the disk can hold so many bytes. False without a scratch
/// file.
[[nodiscard]] bool mayHold(double bytes);

/// Called by threads that sweep much memory, before they touch the next bytes: a thread that outruns eviction waits
/// here.
inline void breathe(std::size_t bytes)
{
    Memory* const memory = detail::gMemory.load(std::memory_order_acquire);
    if (__builtin_expect(memory != nullptr, 0)) memory->breathe(bytes);
}
inline constexpr std::size_t kLeafBytes = 16384;    ///< touched by work on a leaf, about
inline constexpr std::size_t kPointBytes = 1 << 19; ///< touched by a lookup far from the last one

/// Why the scratch file could not grow, as a message; null if it could. May be called in a signal handler.
[[nodiscard]] const char* problem() noexcept;
/// The message for a bus error at an address: the disk fails a page of the scratch file. Null if the address
/// is not in it. May be called in a signal handler.
[[nodiscard]] const char* failureAt(const void* address) noexcept;
/// @throws OutputError with problem() if there is one
void checkScratch();

} // namespace vdblic::paging
