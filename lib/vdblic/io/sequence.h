#pragma once

#include "vdblic/core/parameters.h"
#include "vdblic/core/reporter.h"
#include "vdblic/io/frame_list.h"
#include "vdblic/io/frame_pattern.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

struct VdbFile;

/// One file of a sequence.
struct FrameFile {
    std::int64_t frame = 1;
    std::filesystem::path path;                ///< of a frame in memory: what messages call it
    std::shared_ptr<const VdbFile> contents{}; ///< of a frame in memory
    std::int64_t repeats = 0;                  ///< of a steady field: frames since the one on disk

    /// Frame and path for messages: "frame 3: v.0003.vdb"; of a frame in memory its path.
    [[nodiscard]] std::string label() const;
};

/// Returns the next file of a sequence, or nothing at its end.
using FrameSource = std::function<std::optional<FrameFile>()>;

/// A source that repeats the only frame of another one, numbered on: a field that stands still.
/// @param frames of the result
[[nodiscard]] FrameSource steadySource(FrameSource one, int frames);

/// How to select the files of an input sequence.
struct SequenceParams {
    std::string pattern;                    ///< one file, a pattern, or `-` for paths on standard input
    std::string frames;                     ///< a frame list; empty for every frame found
    bool clampFrames = false;               ///< leave out listed frames before the first or after the last on disk
    std::optional<std::int64_t> renumber{}; ///< number paths on standard input from here, whatever their names
    int steadyFrames = 1;                   ///< above 1: times that the sequence's single frame is repeated
};

/// The parameters of an input sequence. @param name of the positional argument  @param text that describes the sequence
[[nodiscard]] Parameters parametersOf(SequenceParams& params, std::string_view name, std::string_view text);

/// The parameter `skip_existing` of stages whose outputs are independent of each other.
[[nodiscard]] Parameter skipExistingParameter(bool& target);

/// The sequences that a command line names. Files that a shell lists for `name.*.vdb` are frames of one sequence.
[[nodiscard]] std::vector<SequenceParams> sequencesNamed(const std::vector<std::string>& names);

/// The files a sequence selects; all of them exist.
///
/// @throws InputError naming the missing frame, ParameterError on a frame list for a single file, or on several frames
///         that are to be steady
[[nodiscard]] std::vector<FrameFile> selectFrames(const SequenceParams& params);

/// Warn of files beside the frames of a pattern that it does not match (FramePattern::otherNumbersOnDisk()), if every
/// frame found is to be used.
void warnOfOtherNumbers(const SequenceParams& params, Reporter& reporter);

/// The numbers of the frames that a sequence selects. @throws as selectFrames()
[[nodiscard]] std::vector<std::int64_t> selectedFrames(const SequenceParams& params);

/// The frames on disk around those that a sequence selects from a pattern, at the spacing of the selected ones.
struct FramesAround {
    std::vector<std::int64_t> before; ///< without a gap, up to the first selected frame
    std::optional<std::int64_t> after;
};
/// @throws as selectFrames()
[[nodiscard]] FramesAround framesAround(const SequenceParams& params);

/// The least difference of neighbouring frame numbers on disk; 1 for fewer than two frames.
[[nodiscard]] std::int64_t frameSpacing(const SequenceParams& params);

/// The files of selectFrames() one by one. For the pattern `-`, the paths of a PathList are read from `lines` on
/// demand.
/// @param lines must outlive the result
/// @param count receives the number of frames; 0 if it is unknown
/// @throws InputError, the result too: if a file is missing, or its name has no frame number or that of another;
/// ParameterError
[[nodiscard]] FrameSource openSequence(const SequenceParams& params, std::istream& lines, std::size_t& count);

} // namespace vdblic
