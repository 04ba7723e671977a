#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace vdblic {

/// The offsets of the parts of a .vdb file.
struct VdbLayout {
    /// One grid: descriptor, metadata, transform, tree and voxels occupy the bytes from `begin` to `end`.
    struct Grid {
        std::string name, type;
        std::uint64_t begin = 0, end = 0;
        std::uint64_t memory = 0; ///< bytes of the grid in memory, as stated by its writer; 0 if unknown
    };
    /// The file metadata `checksum` of files of this library.
    struct Checksum {
        std::string text;
        std::uint64_t offset = 0; ///< of the text
    };

    static constexpr std::uint64_t kIdentityOffset = 21; ///< after magic number, versions and the flag `seekable`
    static constexpr std::uint64_t kIdentityLength = 36;

    std::string identity; ///< a UUID; random in files of other programs
    Checksum checksum;
    std::uint64_t headerEnd = 0; ///< the offset of the first grid
    bool seekable = true;        ///< whether the file stores the grids' offsets; if not, `grids` is empty
    std::vector<Grid> grids;
};

/// Find the parts of a file and check its headers, which OpenVDB trusts: magic number, versions, the lengths of strings
/// and metadata, the order of offsets, transform types.
///
/// Safe on any bytes; reads no voxels. @param size of the file in bytes
/// @throws InputError with the reason, but not the file, which the caller adds
[[nodiscard]] VdbLayout readLayout(std::istream& stream, std::uint64_t size);

} // namespace vdblic
