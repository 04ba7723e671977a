#pragma once

#include "vdblic/io/vdb_layout.h"

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <string>

namespace vdblic {

/// Files written by this library have the file metadata `checksum`: a hash of the header and one of each grid. They are
/// hashes of the stored bytes, so that a file can be checked before any of it is parsed. A hash is XXH3 of 64 bits, as
/// 16 hexadecimal digits; commas separate hashes.
///
/// The file's identity is derived from the checksums. Another program that copies the metadata into a new file gives
/// that file a random identity, so the copied checksums do not apply to it.

/// A placeholder of the same length as the checksums of a file with so many grids.
[[nodiscard]] std::string emptyChecksums(std::size_t grids);

/// The checksums of a file. They exclude the bytes of the identity and of the checksums.
[[nodiscard]] std::string computeChecksums(std::istream& stream, const VdbLayout& layout);

/// The identity of a file with these checksums, a version 8 UUID (RFC 9562).
[[nodiscard]] std::string identityOf(const std::string& checksums);

/// Whether the file has checksums that, judged by its identity, were written for it.
[[nodiscard]] bool hasChecksums(const VdbLayout& layout);

/// Check a file for which hasChecksums() holds. @param size of the file in bytes
/// @throws InputError naming the damaged grids, but not the file
void verifyChecksums(std::istream& stream, const VdbLayout& layout, std::uint64_t size);

} // namespace vdblic
