#pragma once

#include "vdblic/io/sequence.h"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace vdblic::view {

/// A file of a sequence as it was on disk.
struct FileSeen {
    std::int64_t frame;
    std::uintmax_t size;
    std::filesystem::file_time_type time; ///< of its last change

    [[nodiscard]] bool operator==(const FileSeen&) const = default;
};

/// The selected files on disk, by frame: a removed one leaves a gap. @throws Error
[[nodiscard]] std::vector<FileSeen> filesOnDisk(const SequenceParams& input);

/// The copies of a frame that vdblic_export made, each half as fine as the one before, up to the first that is missing
/// or older than the frame. @throws Error
[[nodiscard]] std::vector<FrameFile> coarserCopies(const SequenceParams& input, const FrameFile& file);

} // namespace vdblic::view
