#include "vdblic/io/frame_list.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <set>
#include <string>
#include <system_error>

namespace vdblic {
namespace {

/// Remove a number from the front of a text and return it, if there is one.
std::optional<std::int64_t> takeNumber(std::string_view& text)
{
    constexpr std::int64_t kMost = 1'000'000'000'000;
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || number > kMost || number < -kMost) return std::nullopt;
    text.remove_prefix(std::size_t(end - text.data()));
    return number;
}

bool take(std::string_view& text, char expected)
{
    if (!text.starts_with(expected)) return false;
    text.remove_prefix(1);
    return true;
}

/// N, N-M or N-MxSTEP.
struct FrameRange {
    std::int64_t first, last, step = 1;
};

std::optional<FrameRange> parseFrameRange(std::string_view text)
{
    while (take(text, ' ')) {
    }
    while (text.ends_with(' '))
        text.remove_suffix(1);
    const auto first = takeNumber(text);
    if (!first) return std::nullopt;
    FrameRange range{*first, *first};
    if (take(text, '-')) {
        const auto last = takeNumber(text);
        if (!last) return std::nullopt;
        range.last = *last;
        if (take(text, 'x')) {
            const auto step = takeNumber(text);
            if (!step) return std::nullopt;
            range.step = *step;
        }
    }
    return text.empty() ? std::optional(range) : std::nullopt;
}

} // namespace

std::vector<std::int64_t> parseFrameList(std::string_view text)
{
    std::set<std::int64_t> frames;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        const std::string_view part = text.substr(begin, end - begin);
        begin = end + 1;
        const auto range = parseFrameRange(part);
        const auto refuse = [&](const std::string& reason) {
            throw ParameterError(fmt::format("frame list '{:.60}': {}", text, reason));
        };
        if (!range) {
            refuse(fmt::format("'{:.60}' is not N, N-M or N-MxSTEP, or a number is out of range", part));
        }
        const auto [first, last, step] = *range;
        if (last < first) refuse(fmt::format("{} runs backwards", part));
        if (step < 1) refuse("the step must be at least 1");
        if (static_cast<std::size_t>((last - first) / step) + frames.size() >= kMaxFrames) {
            refuse(fmt::format("it selects more than {} frames", kMaxFrames));
        }
        for (std::int64_t frame = first; frame <= last; frame += step)
            frames.insert(frame);
    }
    return {frames.begin(), frames.end()};
}

} // namespace vdblic
