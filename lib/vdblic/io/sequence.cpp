#include "vdblic/io/sequence.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/input_file.h"
#include "vdblic/io/path_list.h"
#include "vdblic/io/pattern_advice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <istream>
#include <map>
#include <memory>
#include <utility>

namespace vdblic {
namespace {

std::int64_t leastSpacing(const std::vector<std::int64_t>& frames)
{
    std::int64_t spacing = 0;
    for (std::size_t i = 1; i < frames.size(); ++i) {
        const std::int64_t difference = frames[i] - frames[i - 1];
        spacing = spacing == 0 ? difference : std::min(spacing, difference);
    }
    return std::max<std::int64_t>(spacing, 1);
}

/// The frames found, and in each gap one frame that is not on disk, to be reported as missing.
std::vector<std::int64_t> everyFrame(const std::vector<std::int64_t>& found)
{
    std::vector<std::int64_t> frames;
    const std::int64_t spacing = leastSpacing(found);
    for (std::size_t i = 0; i < found.size(); ++i) {
        frames.push_back(found[i]);
        const bool gap = i + 1 < found.size() && found[i + 1] - found[i] != spacing;
        if (gap) frames.push_back(found[i] + spacing);
    }
    return frames;
}

/// "SUBJECT leaves out v.998.vdb and 1 more: ...", which says how these files are used; empty if there are none.
std::string leftOutText(std::string_view subject, const FramePattern& pattern)
{
    const std::vector<std::string> others = pattern.otherNumbersOnDisk();
    if (others.empty()) return {};
    const std::string more = others.size() > 1 ? fmt::format(" and {} more", others.size() - 1) : "";
    const std::string meant = pattern.onDisk(others.front());
    return fmt::format("{} leaves out {}{}: {}", subject, others.front(), more,
                       meant.empty() ? "pass subframes as paths on standard input, numbered by `renumber`"
                                     : meant + " matches numbers of that width");
}

/// @param frames asked of a steady field  @param found the frames found, more than one
[[noreturn]] void refuseSteady(int frames, const std::string& found)
{
    throw ParameterError(
        fmt::format("`steady_frames` {} repeats a single frame, and there are {}: name one file, or one "
                    "frame with `frames`",
                    frames, found));
}

/// The selected files; the only file of a steady field is repeated.
std::vector<FrameFile> repeated(std::vector<FrameFile> files, const SequenceParams& params)
{
    if (params.steadyFrames == 1) return files;
    if (files.size() > 1) refuseSteady(params.steadyFrames, fmt::format("{} in {}", files.size(), params.pattern));
    for (int i = 1; i < params.steadyFrames; ++i) {
        FrameFile next = files.back();
        ++next.frame;
        ++next.repeats;
        files.push_back(std::move(next));
    }
    return files;
}

} // namespace

Parameters parametersOf(SequenceParams& params, std::string_view name, std::string_view text)
{
    constexpr double kMostNumber = 1e12; // of a frame
    return {
        parameter("input", text, params.pattern, {.option = name, .isRequired = true}),
        parameter("frames", "Frames to use: 1-100, 1-100x2 or 1,5,9-20; every frame found by default.", params.frames),
        parameter("clamp_frames", "Leave out frames of the selection that lie beyond the files on disk.",
                  params.clampFrames),
        parameter("renumber", "Number paths on standard input from this number on as they come, whatever their names.",
                  params.renumber, {.limits = {-kMostNumber, kMostNumber}}),
    };
}

Parameter skipExistingParameter(bool& target)
{
    return parameter("skip_existing", "Leave outputs that are there as they are, and print their paths.", target);
}

std::string FrameFile::label() const
{
    return contents ? path.string() : fmt::format("frame {}: {}", frame, path.string());
}

std::vector<SequenceParams> sequencesNamed(const std::vector<std::string>& names)
{
    std::vector<SequenceParams> sequences;
    for (std::size_t begin = 0, end = 0; begin < names.size(); begin = end) {
        const std::filesystem::path first(names[begin]);
        const std::string stem = first.stem().string();
        const std::string prefix = stem.substr(0, stem.find_last_not_of("0123456789") + 1);
        const std::string pattern =
            likelyPattern(first.parent_path(), prefix, first.extension().string(), first.filename().string());
        std::vector<std::int64_t> frames;
        const auto addFrame = [&](const std::filesystem::path& file) {
            if (pattern.empty() || file.parent_path() != first.parent_path() || !isFile(file)) return false;
            const FramePattern listed(pattern);
            const auto frame = listed.hasField() ? listed.frameOf(file) : std::nullopt;
            if (frame) frames.push_back(*frame);
            return frame.has_value();
        };
        for (end = begin; end < names.size() && addFrame(names[end]);)
            ++end;
        if (frames.size() < 2) {
            end = begin + 1;
            sequences.push_back({.pattern = names[begin], .frames = {}});
            continue;
        }
        std::sort(frames.begin(), frames.end());
        const bool isAll = frames == FramePattern(pattern).framesOnDisk();
        sequences.push_back({.pattern = pattern, .frames = isAll ? "" : fmt::format("{}", fmt::join(frames, ","))});
    }
    return sequences;
}

std::vector<FrameFile> selectFrames(const SequenceParams& params)
{
    const FramePattern pattern(params.pattern);
    if (!pattern.hasField()) {
        if (!params.frames.empty()) {
            throw ParameterError(
                fmt::format("'{}' is one file; `frames` needs a pattern such as name.%04d.vdb", params.pattern));
        }
        const std::filesystem::path path = pattern.path(1);
        if (!isFile(path)) throw InputError(fmt::format("{}: no such file", path.string()));
        return repeated({{frameOfName(path).value_or(1), path}}, params);
    }

    const std::vector<std::int64_t> found = pattern.framesOnDisk();
    if (found.empty()) {
        const std::string meant = pattern.onDisk();
        throw InputError(fmt::format("{}: no file matches the pattern{}", params.pattern,
                                     meant.empty() ? leftOutText("; it", pattern)
                                                   : fmt::format("; the files on disk match {}", meant)));
    }
    const bool chosen = !params.frames.empty();
    std::vector<std::int64_t> frames = chosen ? parseFrameList(params.frames) : everyFrame(found);
    if (params.clampFrames) {
        std::erase_if(frames, [&](std::int64_t frame) { return frame < found.front() || frame > found.back(); });
        if (frames.empty()) {
            throw InputError(fmt::format("{}: no frame of {} is on disk; the files are numbered {} to {}",
                                         params.pattern, params.frames, found.front(), found.back()));
        }
    }

    std::vector<FrameFile> files;
    files.reserve(frames.size());
    for (const std::int64_t frame : frames) {
        if (!std::binary_search(found.begin(), found.end(), frame)) {
            const bool overshoots = frame < found.front() || frame > found.back();
            throw InputError(fmt::format("frame {} is missing: {}; {}{}", frame, pattern.path(frame).string(),
                                         overshoots ? "`clamp_frames` leaves out what lies beyond the files on disk"
                                                    : "`frames` can select the others",
                                         leftOutText("; the pattern", pattern)));
        }
        files.push_back({frame, pattern.path(frame)});
    }
    return repeated(std::move(files), params);
}

void warnOfOtherNumbers(const SequenceParams& params, Reporter& reporter)
{
    if (params.pattern == "-" || !params.frames.empty()) return;
    try {
        const FramePattern pattern(params.pattern);
        if (!pattern.hasField() || pattern.framesOnDisk().empty()) return;
        const std::string text = leftOutText(params.pattern, pattern);
        if (!text.empty()) reporter.warn(text);
    } catch (const Error&) { // reported when the sequence is opened
    }
}

std::vector<std::int64_t> selectedFrames(const SequenceParams& params)
{
    std::vector<std::int64_t> frames;
    for (const FrameFile& file : selectFrames(params))
        frames.push_back(file.frame);
    return frames;
}

FramesAround framesAround(const SequenceParams& params)
{
    if (params.frames.empty() || params.pattern == "-" || params.steadyFrames > 1) return {};
    const std::vector<std::int64_t> selected = selectedFrames(params);
    const std::vector<std::int64_t> found = FramePattern(params.pattern).framesOnDisk();
    const auto isThere = [&](std::int64_t frame) { return std::binary_search(found.begin(), found.end(), frame); };
    const std::size_t count = selected.size();
    const std::int64_t spacing = leastSpacing(found);
    const std::int64_t first = count > 1 ? selected[1] - selected[0] : spacing;
    const std::int64_t last = count > 1 ? selected[count - 1] - selected[count - 2] : spacing;
    FramesAround around;
    for (std::int64_t frame = selected.front() - first; isThere(frame); frame -= first)
        around.before.insert(around.before.begin(), frame);
    if (isThere(selected.back() + last)) around.after = selected.back() + last;
    return around;
}

std::int64_t frameSpacing(const SequenceParams& params)
{
    const FramePattern pattern(params.pattern);
    return pattern.hasField() && params.steadyFrames == 1 ? leastSpacing(pattern.framesOnDisk()) : 1;
}

FrameSource steadySource(FrameSource one, int frames)
{
    return [one = std::move(one), frames, next = std::optional<FrameFile>{}]() mutable -> std::optional<FrameFile> {
        if (next) {
            ++next->frame;
            ++next->repeats;
        } else {
            next = one();
            if (next && one()) refuseSteady(frames, "several");
        }
        return next && next->repeats < frames ? next : std::nullopt;
    };
}

FrameSource openSequence(const SequenceParams& params, std::istream& lines, std::size_t& count)
{
    if (params.pattern == "-") {
        if (!params.frames.empty()) throw ParameterError("`frames` cannot select from paths on standard input");
        count = params.steadyFrames > 1 ? std::size_t(params.steadyFrames) : 0;
        FrameSource source = [paths = PathList(lines), next = params.renumber,
                              taken = std::map<std::int64_t, std::string>{}]() mutable -> std::optional<FrameFile> {
            const std::optional<std::string> path = paths.next();
            if (!path) return std::nullopt;
            if (!isFile(*path)) throw InputError(fmt::format("{:.300}: no such file (named on standard input)", *path));
            const std::optional<std::int64_t> frame = next ? (*next)++ : frameOfName(*path);
            if (!frame) {
                throw InputError(
                    fmt::format("{}: the name does not end in a frame number; `renumber` START numbers the "
                                "paths as they come",
                                *path));
            }
            // Outputs are named by frame: the second would overwrite the first.
            if (const auto [before, isNew] = taken.emplace(*frame, *path); !isNew) {
                throw InputError(fmt::format("{}: frame {} comes twice on standard input; the first was {}; `renumber` "
                                             "START numbers the paths as they come",
                                             *path, *frame, before->second));
            }
            return FrameFile{*frame, *path};
        };
        return params.steadyFrames > 1 ? steadySource(std::move(source), params.steadyFrames) : source;
    }
    if (params.renumber) throw ParameterError("`renumber` is for paths on standard input; a pattern has the numbers");
    auto files = std::make_shared<std::vector<FrameFile>>(selectFrames(params));
    count = files->size();
    return [files, next = std::size_t{0}]() mutable -> std::optional<FrameFile> {
        if (next == files->size()) return std::nullopt;
        return (*files)[next++];
    };
}

} // namespace vdblic
