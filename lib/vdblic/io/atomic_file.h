#pragma once

#include <filesystem>
#include <string_view>

namespace vdblic {

/// Whether an output is there, and so finished: outputs have their final names only when they are complete.
[[nodiscard]] bool isFinished(const std::filesystem::path& output);

/// An output that appears under its final name complete or not at all.
///
/// Write to temporary(), then commit(): the data is flushed to disk, the file renamed, the folder flushed. Without
/// commit() nothing stays. The temporary file has no name until commit(), so that a killed process leaves none behind.
/// File systems that cannot do that (NFS) get a hidden one with the name `.FINAL.part`; what a killed process leaves
/// under it is removed by the next that writes the same output.
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
