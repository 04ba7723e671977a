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

/// Check that an allocation of `needed` bytes fits into memory.
/// @param what names the allocation in the message  @param mend the remedy besides more memory
/// @throws InputError if it exceeds memoryLimit()
void checkMemory(double needed, const std::string& what, const std::string& mend);

/// Check that `count` voxels fit into memory, at the fewest bytes per voxel of any computation.
/// @param where  prefix of the message; may be empty  @param ranks that share the voxels
/// @param stored voxels stored one by one in files: a scratch file may hold them (paging.h). The others, expanded from
///               tiles, must fit into memory. @throws InputError
void checkVoxels(std::uint64_t count, const std::string& where = "", int ranks = 1, std::uint64_t stored = 0);

} // namespace vdblic
