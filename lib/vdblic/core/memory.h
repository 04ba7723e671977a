#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace vdblic {

/// The bytes this process may hold: the least of the machine's memory, its control group's limit, and the process's
/// own limit on data (`ulimit -d`, RLIMIT_DATA), by which a program sets itself a budget.
[[nodiscard]] std::uint64_t memoryLimit();

/// Parse `800M`, `16G`, `1.5T`: a number of bytes, or of units of 1024, its square and so on, K to T.
/// @throws ParameterError on anything else, 0, or more than 1024 T
[[nodiscard]] std::uint64_t parseMemory(std::string_view text);

/// "1.5 GiB"
[[nodiscard]] std::string memoryText(double bytes);

/// Check that something fits before it is allocated.
/// @param needed in bytes  @param what is to be allocated, for the message  @param mend what helps besides more memory
/// @throws InputError if it exceeds memoryLimit()
void checkMemory(double needed, const std::string& what, const std::string& mend);

/// Check that so many voxels fit, at the least that any work on them takes, before tiles are expanded to them.
/// @param where named in the message; may be empty. @throws InputError
void checkVoxels(std::uint64_t count, const std::string& where = "");

} // namespace vdblic
