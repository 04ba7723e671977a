#pragma once

#include <cstddef>
#include <cstdint>

namespace vdblic {

/// Memory figures of the system, and the settings of its allocator: the one place that knows Linux's files and
/// glibc's allocator.

/// Memory of this process [bytes].
struct ProcessMemory {
    std::uint64_t resident = 0;
    std::uint64_t files = 0;     ///< of these, mapped files
    std::uint64_t data = 0;      ///< counted against RLIMIT_DATA
    std::uint64_t addresses = 0; ///< counted against RLIMIT_AS
};
/// Figures of this process; zeros if unreadable. Allocates nothing; signal handlers may call it.
[[nodiscard]] ProcessMemory processMemory();

/// Bytes available without swapping; UINT64_MAX if unreadable.
[[nodiscard]] std::uint64_t freeMemory();

/// The least limit of this process's control groups (v1 or v2) and of their ancestors [bytes].
[[nodiscard]] std::uint64_t groupMemoryLimit();

/// Limit the allocator's arenas to the number of threads: an arena cannot reuse memory freed in another.
void limitArenas(std::size_t threads);

} // namespace vdblic
