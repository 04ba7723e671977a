#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace vdblic {

/// The bytes of the machine's memory, or the control group's limit if that is less.
[[nodiscard]] std::uint64_t machineMemory();

/// The bytes this process may use: machineMemory(), or the process's limit on data or on addresses (`ulimit -d`,
/// RLIMIT_DATA; `ulimit -v`, RLIMIT_AS) if that is less. A program may set the one on data as its budget.
[[nodiscard]] std::uint64_t memoryLimit();

/// Parse `800M`, `16G`, `1.5T`: a number of bytes, or of KiB, MiB, GiB or TiB with a suffix K to T.
/// @throws ParameterError on anything else, 0, or more than 1024 T
[[nodiscard]] std::uint64_t parseMemory(std::string_view text);

/// "1.5 GiB"
[[nodiscard]] std::string memoryText(double bytes);

/// Tell that the program has an option `max_memory`, for messages.
void setMemoryOption();
[[nodiscard]] bool hasMemoryOption();

/// Advice on getting more memory, for messages: "raise `max_memory`" in a program that has that.
[[nodiscard]] std::string_view memoryMend();

/// Check that an allocation fits into the memory.
/// @param needed in bytes  @param what names the allocation in the message  @param mend the remedy besides more memory
/// @throws InputError if it exceeds memoryLimit()
void checkMemory(double needed, const std::string& what, const std::string& mend);

/// Check that tiles can be expanded to so many voxels, at the least memory that any work on voxels takes.
/// @param where  prefix of the message; may be empty  @param ranks that share the voxels
/// @param stored the voxels that files hold one by one; they may lie in a scratch file (paging.h). Voxels that tiles
///               expand to must fit into memory. @throws InputError
void checkVoxels(std::uint64_t count, const std::string& where = "", int ranks = 1, std::uint64_t stored = 0);

} // namespace vdblic
