#pragma once

#include "vdblic/core/parameters.h"
#include "vdblic/core/reporter.h"
#include "vdblic/io/frame_list.h"

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

/// A file name with at most one frame field: `%04d`, `####`, `@@@@`, `$F4` or `<F4>`.
///
/// The field must be in the last component of the path. Without a field the pattern names one file.
class FramePattern {
  public:
    /// @throws ParameterError on an empty name, two fields, a field in a folder's name, or what is probably a mistyped
    ///         field
    explicit FramePattern(std::string_view pattern);

    [[nodiscard]] bool hasField() const { return mWidth.has_value(); }
    [[nodiscard]] const std::string& text() const { return mText; }

    /// The path of a frame. Zero-padded as by printf, where a sign counts towards the width: -003 for `%04d`. If only
    /// the file with all digits is on disk, -0003, that is the path.
    [[nodiscard]] std::filesystem::path path(std::int64_t frame) const;

    /// A further file in the frames' folder: the given name followed by the constant part of the frames' names, such as
    /// checkpoint.lic.vdb for `checkpoint` and lic.%04d.vdb.
    [[nodiscard]] std::filesystem::path companion(std::string_view name) const;

    /// The pattern of coarser copies beside the frames (field/coarser.h): lic.level1.%04d.vdb for level 1 of
    /// lic.%04d.vdb, lic.level1.vdb for lic.vdb.
    [[nodiscard]] FramePattern ofLevel(int level) const;

    /// A pattern that files on disk match, which differ from this one's in the width of the field; empty if none do.
    /// @param name of the file to match; empty: any
    [[nodiscard]] std::string onDisk(const std::string& name = {}) const;

    /// The frames on disk, in numeric order. @throws InputError if the folder cannot be read
    [[nodiscard]] std::vector<std::int64_t> framesOnDisk() const;

    /// Names of the files beside the frames that have another number where the pattern has its field: of a subframe,
    /// such as 1001.25, or padded to another width. In alphabetical order. Only for a pattern with a field.
    [[nodiscard]] std::vector<std::string> otherNumbersOnDisk() const;

    /// The frame whose file has this name, if any; the folder is ignored. Only for a pattern with a field.
    [[nodiscard]] std::optional<std::int64_t> frameOf(const std::filesystem::path& path) const;

  private:
    [[nodiscard]] std::optional<std::string_view> fieldOf(std::string_view name) const;
    [[nodiscard]] std::vector<std::string> namesOnDisk() const;

    std::string mText;
    std::filesystem::path mFolder;
    std::string mPrefix, mSuffix;
    std::optional<int> mWidth; // of the frame field; 1 for no padding
};

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
    int steadyFrames = 1;                   ///< above 1: the sequence is one frame that is repeated so often
};

/// Those of an input sequence. @param name of the positional argument  @param text what the sequence is
[[nodiscard]] Parameters parametersOf(SequenceParams& params, std::string_view name, std::string_view text);

/// Of stages whose outputs are independent of each other.
[[nodiscard]] Parameter skipExistingParameter(bool& target);

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

/// The frame number a file name ends with (`smoke_0012.vdb` → 12), if there is one. The end of a date or of a time
/// (`2005-08-28_00:00:00`) is none.
[[nodiscard]] std::optional<std::int64_t> frameOfName(const std::filesystem::path& path);

} // namespace vdblic
