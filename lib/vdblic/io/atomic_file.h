#pragma once

#include <filesystem>
#include <string_view>

namespace vdblic {

/// Whether an output exists and so is complete: an output has its final name only then.
[[nodiscard]] bool isFinished(const std::filesystem::path& output);

/// An output that appears under its final name complete or not at all.
///
/// Write to temporary(), then commit(): the data is flushed to disk, the file renamed, the folder flushed. Without
/// commit() nothing stays. The temporary file has no name until commit(), so that a killed process leaves none behind.
/// On file systems without unnamed files (NFS) it has the hidden name `.FINAL.HOST-N.part`, N the first number that no
/// living process uses. Writers of one output, in one process or several, so never share a file: the last commit()
/// wins. What a killed process leaves is removed by the next on its host that writes the same output. A lock (flock)
/// tells the living from the dead, not a process number, which may be used again or belong to another container.
class AtomicFile {
  public:
    enum class Temporary { kUnnamedIfPossible, kNamed };

    /// @throws OutputError if the folder does not exist or is not writable, or the final name is a folder
    explicit AtomicFile(std::filesystem::path final, Temporary kind = Temporary::kUnnamedIfPossible);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// Where to write, until commit().
    [[nodiscard]] const std::filesystem::path& temporary() const { return mTemporary; }

    /// @throws OutputError naming the file and the system's reason; the final name is then as it was
    void commit();

  private:
    std::filesystem::path mFinal, mNamed, mTemporary;
    int mDescriptor = -1;
    bool mUnnamed = false;
};

/// Check that writing an output will not replace an input. @throws ParameterError if they are the same file
void checkNotInput(const std::filesystem::path& output, const std::filesystem::path& input);
/// Check that two outputs of a run have different names, whether they exist or not. @throws ParameterError
void checkDistinct(const std::filesystem::path& output, const std::filesystem::path& other);

/// Write a text as an AtomicFile. @throws OutputError naming the file and the system's reason
void writeTextFile(const std::filesystem::path& path, std::string_view text);

} // namespace vdblic
