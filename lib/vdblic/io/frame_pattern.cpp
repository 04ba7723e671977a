#include "vdblic/io/frame_pattern.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/input_file.h"
#include "vdblic/io/pattern_advice.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <iterator>
#include <regex>
#include <system_error>

namespace vdblic {
namespace {

/// A number formatted as by printf's %0*d.
std::string padded(std::int64_t frame, int width)
{
    return fmt::format("{:0{}d}", frame, width);
}

// PATH_MAX. std::regex matches by recursion, so the length must be bounded.
constexpr std::size_t kLongestPattern = 4096;

} // namespace

FramePattern::FramePattern(std::string_view pattern) : mText(pattern)
{
    if (pattern.size() > kLongestPattern) {
        throw ParameterError(
            fmt::format("'{:.60}...' has {} characters; no file's name is that long", pattern, pattern.size()));
    }
    const std::filesystem::path whole(mText);
    mFolder = whole.parent_path();
    const std::string name = whole.filename().string();
    if (name.empty()) throw ParameterError(fmt::format("'{}' is not a file name", pattern));
    mPrefix = name;
    // An existing file of exactly this name is meant literally, even if the name looks like a pattern.
    if (isFile(whole)) return;

    static const std::regex field(R"(%(0\d+)?d|#+|@+|\$F(\d*)|<F(\d*)>)");
    if (const std::string folder = mFolder.string();
        std::regex_search(folder, std::regex(R"(%(0\d+)?d|\$F\d|<F\d+>)"))) {
        throw ParameterError(
            fmt::format("'{}': the frame field must stand in the file name, not in a folder's", pattern));
    }
    std::smatch match;
    if (!std::regex_search(name, match, field)) {
        const std::string advice = patternAdvice(whole);
        if (!advice.empty()) throw ParameterError(fmt::format("'{}': {}", pattern, advice));
        return;
    }
    mPrefix = match.prefix();
    mSuffix = match.suffix();
    if (std::regex_search(mSuffix, field)) {
        throw ParameterError(fmt::format("'{}' has more than one frame field; keep one", pattern));
    }
    const std::string found = match.str();
    if (found[0] == '#' || found[0] == '@') {
        mWidth = static_cast<int>(found.size());
    } else {
        std::string digits;
        std::copy_if(found.begin(), found.end(), std::back_inserter(digits),
                     [](char c) { return c >= '0' && c <= '9'; });
        int width = digits.empty() ? 1 : 0;
        std::from_chars(digits.data(), digits.data() + digits.size(), width);
        if (width < 1 || width > 20) {
            throw ParameterError(fmt::format("'{}': a frame field is 1 to 20 digits wide", pattern));
        }
        mWidth = width;
    }
}

FramePattern FramePattern::ofLevel(int level) const
{
    const std::filesystem::path name = std::filesystem::path(mText).filename();
    const std::size_t after = hasField() ? name.native().size() - mPrefix.size() : name.extension().native().size();
    const std::string word = hasField() ? fmt::format("level{}.", level) : fmt::format(".level{}", level);
    return FramePattern(std::string(mText).insert(mText.size() - after, word));
}

std::filesystem::path FramePattern::path(std::int64_t frame) const
{
    if (!hasField()) return mFolder / mPrefix;
    std::filesystem::path usual = mFolder / (mPrefix + padded(frame, *mWidth) + mSuffix);
    if (frame >= 0) return usual;
    std::filesystem::path allDigits = mFolder / (mPrefix + padded(frame, *mWidth + 1) + mSuffix);
    if (isFile(usual) || !isFile(allDigits)) return usual;
    return allDigits;
}

std::filesystem::path FramePattern::companion(std::string_view name) const
{
    std::string common = mPrefix;
    if (hasField()) common.erase(common.find_last_not_of("._-") + 1);
    return mFolder / fmt::format("{}{}{}{}", name, common.empty() ? "" : ".", common, mSuffix);
}

/// The text in the field's place in a file's name; nothing if the rest of the name differs.
std::optional<std::string_view> FramePattern::fieldOf(std::string_view name) const
{
    if (name.size() <= mPrefix.size() + mSuffix.size()) return std::nullopt;
    if (!name.starts_with(mPrefix) || !name.ends_with(mSuffix)) return std::nullopt;
    return name.substr(mPrefix.size(), name.size() - mPrefix.size() - mSuffix.size());
}

std::optional<std::int64_t> FramePattern::frameOf(const std::filesystem::path& path) const
{
    const std::string name = path.filename().string();
    const std::optional<std::string_view> field = fieldOf(name);
    if (!field) return std::nullopt;
    std::int64_t frame = 0;
    const auto [last, failed] = std::from_chars(field->data(), field->data() + field->size(), frame);
    if (failed != std::errc{} || last != field->data() + field->size()) return std::nullopt;
    // Only the spelling of this pattern counts: with %04d, 0007 is frame 7 and 7 is not.
    const bool isSpelled = padded(frame, *mWidth) == *field || (frame < 0 && padded(frame, *mWidth + 1) == *field);
    return isSpelled ? std::optional(frame) : std::nullopt;
}

std::string FramePattern::onDisk(const std::string& name) const
{
    return likelyPattern(mFolder, mPrefix, mSuffix, name);
}

/// The names of the files in the frames' folder, in alphabetical order.
std::vector<std::string> FramePattern::namesOnDisk() const
{
    const std::filesystem::path folder = mFolder.empty() ? "." : mFolder;
    std::error_code error;
    std::filesystem::directory_iterator entries(folder, error);
    if (error) throw InputError(fmt::format("{}: cannot read the folder: {}", folder.string(), error.message()));

    std::vector<std::string> names;
    for (const auto& entry : entries) {
        if (!entry.is_directory(error)) names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
}

std::vector<std::int64_t> FramePattern::framesOnDisk() const
{
    std::vector<std::int64_t> frames;
    for (const std::string& name : namesOnDisk()) {
        if (const auto frame = frameOf(name)) frames.push_back(*frame);
    }
    std::sort(frames.begin(), frames.end());
    frames.erase(std::unique(frames.begin(), frames.end()), frames.end()); // -003 and -0003 are one frame
    return frames;
}

std::vector<std::string> FramePattern::otherNumbersOnDisk() const
{
    static const std::regex number(R"(-?\d+(\.\d+)?)");
    std::vector<std::string> names = namesOnDisk();
    std::erase_if(names, [&](const std::string& name) {
        const std::optional<std::string_view> field = fieldOf(name);
        if (!field || !std::regex_match(field->begin(), field->end(), number)) return true;
        const std::optional<std::int64_t> frame = frameOf(name);
        return frame && path(*frame).filename() == name;
    });
    return names;
}

std::optional<std::int64_t> frameOfName(const std::filesystem::path& path)
{
    const std::string stem = path.stem().string();
    std::size_t begin = stem.size();
    while (begin > 0 && stem[begin - 1] >= '0' && stem[begin - 1] <= '9')
        --begin;
    if (begin == stem.size() || stem.size() - begin > 12) return std::nullopt;
    // A minus is a sign only after a separator: sim-12 is frame 12, sim.-12 is frame −12.
    const bool negative =
        begin > 0 && stem[begin - 1] == '-' && (begin == 1 || stem[begin - 2] == '.' || stem[begin - 2] == '_');
    static const std::regex dateOrTime(R"((\d-\d\d?-|\d:)\d\d?$)");
    if (std::regex_search(stem.substr(stem.size() - std::min<std::size_t>(stem.size(), 8)), dateOrTime)) {
        return std::nullopt;
    }
    const std::int64_t frame = std::stoll(stem.substr(begin));
    return negative ? -frame : frame;
}

} // namespace vdblic
