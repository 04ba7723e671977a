#pragma once

#include <cstddef>
#include <cstdint>

namespace vdblic {

/// Memory figures of the system, and the settings of its allocator: the one place that knows Linux's files and
/// glibc's allocator.

/// Of this process [bytes].
struct ProcessMemory {
    std::uint64_t resident = 0;
    std::uint64_t files = 0;     ///< of these, mapped files
    std::uint64_t data = 0;      ///< counted against RLIMIT_DATA
    std::uint64_t addresses = 0; ///< counted against RLIMIT_AS
};
/// Allocates nothing; signal handlers may call it. Nothing where it cannot be read.
[[nodiscard]] ProcessMemory processMemory();

/// The bytes available without swapping; no limit where it cannot be read.
[[nodiscard]] std::uint64_t freeMemory();

/// The least limit of this process's control groups (v1 or v2) and of their ancestors [bytes].
[[nodiscard]] std::uint64_t groupMemoryLimit();

/// Let the allocator keep no more arenas than there are threads: an arena has no use of memory that threads of others
/// freed.
void limitArenas(std::size_t threads);

} // namespace vdblic
