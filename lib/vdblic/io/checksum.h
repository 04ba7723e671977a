#pragma once

#include "vdblic/io/vdb_layout.h"

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <string>

namespace vdblic {

/// Our files tell what their bytes should be: the file metadata `checksum` holds a hash of the header and one of each
/// grid, of the bytes as stored, so that a file is checked before any of it is parsed. Hashes are XXH3, 64 bits as 16
/// hexadecimal digits, with commas between.
///
/// The file's identity is made from that text. A program that reads such a file and writes another gives that a random
/// identity, so checksums that were carried along are not taken for those of the new file.

/// As long as the checksums of a file with so many grids.
[[nodiscard]] std::string emptyChecksums(std::size_t grids);

/// The checksums of a file. The identity and the checksums themselves are left out.
[[nodiscard]] std::string computeChecksums(std::istream& stream, const VdbLayout& layout);

/// The identity of a file with these checksums, a version 8 UUID (RFC 9562).
[[nodiscard]] std::string identityOf(const std::string& checksums);

/// Whether the file has checksums and is as their writer left it, as far as its identity tells.
[[nodiscard]] bool hasChecksums(const VdbLayout& layout);

/// Check a file that hasChecksums(). @param size of the file in bytes
/// @throws InputError naming the damaged grids, without the file's name
void verifyChecksums(std::istream& stream, const VdbLayout& layout, std::uint64_t size);

} // namespace vdblic
