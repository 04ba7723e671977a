#include "vdblic/io/output_pattern.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/atomic_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <optional>

namespace vdblic {

void checkNoFrame(const std::filesystem::path& output, const FramePattern& frames)
{
    const std::optional<std::int64_t> frame = frames.hasField() ? frames.frameOf(output) : 0;
    if (frame) checkDistinct(output, frames.path(*frame));
}

void checkExtension(const std::filesystem::path& path, const std::vector<std::string>& extensions)
{
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    if (std::find(extensions.begin(), extensions.end(), extension) != extensions.end()) return;
    throw ParameterError(fmt::format("output '{}' must end in {}", path.string(), fmt::join(extensions, " or ")));
}

void checkOutputPattern(const FramePattern& pattern, std::size_t frames)
{
    if (!pattern.hasField() && frames != 1) {
        throw ParameterError(fmt::format("output '{}' names one file but there are more frames; use a pattern such as "
                                         "name.%04d.vdb",
                                         pattern.text()));
    }
}

void checkOutputs(const FramePattern& pattern, const std::vector<std::int64_t>& frames)
{
    checkOutputPattern(pattern, frames.size());
    for (const std::int64_t frame : frames)
        checkReplaceable(pattern.path(frame));
    if (!frames.empty()) checkOutput(pattern.path(frames.front()));
}

} // namespace vdblic
