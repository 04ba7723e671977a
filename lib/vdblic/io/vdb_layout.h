#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace vdblic {

/// Where the parts of a .vdb file lie.
struct VdbLayout {
    /// One grid: its descriptor, transform and metadata, tree, and voxels, from `begin` to `end`. Offsets into the
    /// file.
    struct Grid {
        std::string name, type;
        std::uint64_t begin = 0, end = 0;
        std::uint64_t memory = 0; ///< bytes it took in the memory of its writer, as that says; 0 if it does not
    };
    /// The file metadata `checksum` of our own files.
    struct Checksum {
        std::string text;
        std::uint64_t offset = 0; ///< of the text
    };

    static constexpr std::uint64_t kIdentityOffset = 21; ///< after magic number, versions and the flag for offsets
    static constexpr std::uint64_t kIdentityLength = 36;

    std::string identity; ///< an UUID, random in the files of others
    Checksum checksum;
    std::uint64_t headerEnd = 0; ///< where the first grid begins
    bool seekable = true;        ///< without, a file does not tell where its grids lie: `grids` is empty
    std::vector<Grid> grids;
};

/// Find the parts of a file and check all that its headers say, before OpenVDB, which believes them, sees it: magic
/// number, versions, the lengths of strings and metadata, the order of offsets, transform types.
///
/// Safe on any bytes; reads no voxels. @param size of the file in bytes
/// @throws InputError with the reason alone: the file's name is the caller's to give
[[nodiscard]] VdbLayout readLayout(std::istream& stream, std::uint64_t size);

} // namespace vdblic
