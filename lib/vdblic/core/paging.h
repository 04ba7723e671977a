#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace vdblic::paging {

/// \file
/// Memory in a scratch file: what is larger than the memory that may be taken lies on disk, and is resident only as far
/// as it is in use (docs/architecture.md, "Larger than memory").
///
/// The file is mapped into the process and has no name, so nothing is left of it after the process, however that ends.
/// A thread watches how much of the process is resident and lets go of parts of the mapping, in the order in which they
/// were allocated; the system writes and reads them as it does any file's. What is in the memory, and so all results,
/// are the same.
///
/// Like the operator new that allocates here, all of this is of the process, not of an object. Thread-safe.

/// Tell that the program's operator new asks allocate() before it takes other memory. Without that nothing is paged.
void lend();
[[nodiscard]] bool isLent();

/// Allow what follows to begin paging. Nothing is done yet.
/// @param folder  of the scratch file
/// @param limit   of the process's resident memory [bytes]
/// @param inFiles what the job holds at a time, in files that it reads
void offer(const std::filesystem::path& folder, std::uint64_t limit, double inFiles);

/// Make room for what a run takes in all: begin paging if that is more than the limit, or near it. The scratch is then
/// on the disk, so that the disk cannot become full later.
/// @param bytes that the run takes
/// @return whether memory is paged now and the scratch file holds as much; always false without lend() and offer()
/// @throws OutputError, naming the folder and the reason, if the scratch file cannot be made or grow so far
bool makeRoom(double bytes);

/// Begin paging, without room on the disk yet, if a job that reads files of so much memory would need it.
/// @throws OutputError if no scratch file can be made
void expectFiles(double bytes);

/// Whether so much can be held: in memory, and in a scratch file on the disk as it is. Always false without an offer.
[[nodiscard]] bool mayHold(double bytes);

/// Called by threads that work on much memory, before they take up the next so many bytes: a thread that is faster than
/// those that let go waits here. Costs nothing while memory is not paged.
void breathe(std::size_t bytes);
inline constexpr std::size_t kLeafBytes = 16384;    ///< that work on a leaf takes up, about
inline constexpr std::size_t kPointBytes = 1 << 19; ///< that a look around a point far from the last one does

[[nodiscard]] bool isOn(); ///< whether memory is being paged

/// Why the scratch file could not grow, as a message; null if it could. May be called in a signal handler.
[[nodiscard]] const char* problem() noexcept;
/// @throws OutputError with problem() if there is one
void checkScratch();

/// Memory for an object, aligned as by operator new, and to 128 bytes if it has more than 1 KiB; null if memory is not
/// paged, the object is small, or the scratch file cannot grow (problem()).
[[nodiscard]] void* allocate(std::size_t bytes) noexcept;
/// Free memory of allocate(). @return whether it was such
bool release(void* memory) noexcept;

} // namespace vdblic::paging
