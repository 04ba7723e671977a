#include "view/files_on_disk.h"

#include "vdblic/io/frame_list.h"

#include <algorithm>
#include <system_error>

namespace vdblic::view {
namespace {

/// Whether a file is there and no older than another one.
bool isNewer(const std::filesystem::path& path, const std::filesystem::path& than)
{
    std::error_code gone, other;
    const auto time = std::filesystem::last_write_time(path, gone);
    return !gone && time >= std::filesystem::last_write_time(than, other) && !other;
}

} // namespace

std::vector<FileSeen> filesOnDisk(const SequenceParams& input)
{
    const FramePattern pattern(input.pattern);
    std::vector<std::int64_t> frames;
    if (pattern.hasField()) {
        frames = pattern.framesOnDisk();
    } else {
        frames = {frameOfName(pattern.path(1)).value_or(1)};
    }
    if (!input.frames.empty()) {
        const std::vector<std::int64_t> chosen = parseFrameList(input.frames);
        std::erase_if(frames, [&](std::int64_t frame) { return !std::ranges::binary_search(chosen, frame); });
    }
    std::vector<FileSeen> files;
    for (const std::int64_t frame : frames) {
        std::error_code gone, changed;
        const std::filesystem::path path = pattern.path(frame);
        const FileSeen file{frame, std::filesystem::file_size(path, gone),
                            std::filesystem::last_write_time(path, changed)};
        if (!gone && !changed) files.push_back(file);
    }
    return files;
}

std::vector<FrameFile> coarserCopies(const SequenceParams& input, const FrameFile& file)
{
    const FramePattern pattern(input.pattern);
    std::vector<FrameFile> copies;
    for (int level = 1;; ++level) {
        const FrameFile copy{file.frame, pattern.ofLevel(level).path(file.frame)};
        if (!isNewer(copy.path, file.path)) return copies;
        copies.push_back(copy);
    }
}

} // namespace vdblic::view
