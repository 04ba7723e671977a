#pragma once

#include <cstdint>
#include <filesystem>
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
    /// @throws ParameterError on an empty name, two fields, a field in a folder's name, or a field that is
    ///         probably mistyped
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

    /// A pattern with another field width that files on disk match; empty if there is none.
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

/// The frame number a file name ends with (`smoke_0012.vdb` → 12), if there is one. The end of a date or of a time
/// (`2005-08-28_00:00:00`) is none.
[[nodiscard]] std::optional<std::int64_t> frameOfName(const std::filesystem::path& path);

} // namespace vdblic
