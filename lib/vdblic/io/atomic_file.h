#pragma once

#include <filesystem>
#include <string_view>

namespace vdblic {

/// Whether an output exists and so is complete: an output has its final name only then.
[[nodiscard]] bool isFinished(const std::filesystem::path& output);

/// An output that appears under its final name complete or not at all. A symbolic link stays, and the file that it
/// leads to is replaced.
///
/// Write to temporary(), then commit(): the data is flushed to disk, the file renamed, the folder flushed. Without
/// commit() nothing stays. The temporary file has no name until commit(), so that a killed process leaves none behind.
/// On file systems without unnamed files (NFS) it has the hidden name `.FINAL.HOST-N.part`, where N is the first number
/// that no living writer uses. So writers of one output, in one process or several, never share a temporary file; the
/// last commit() wins. The next writer of the same output on the host removes the files of killed writers. A writer
/// locks its file (flock), so that others see it is alive; a process id would not do, since ids are reused and differ
/// between containers.
class AtomicFile {
  public:
    enum class Temporary { kUnnamedIfPossible, kNamed };

    /// @throws ParameterError if a folder, a device or a pipe has the final name; OutputError if the folder is missing
    /// or not writable
    explicit AtomicFile(const std::filesystem::path& final, Temporary kind = Temporary::kUnnamedIfPossible);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// The path to write to until commit().
    [[nodiscard]] const std::filesystem::path& temporary() const { return mTemporary; }

    /// @throws OutputError naming the file and the system's reason; a file of the final name is then unchanged
    void commit();

  private:
    std::filesystem::path mFinal, mNamed, mTemporary;
    int mDescriptor = -1;
    bool mUnnamed = false;
};

/// Remove the temporary files that killed writers of an output left on this host.
void removeLeftovers(const std::filesystem::path& output);

/// Check that an output will not replace an input. @throws ParameterError if they are the same file
void checkNotInput(const std::filesystem::path& output, const std::filesystem::path& input);
/// Check that two outputs of a run have different paths; they need not exist. @throws ParameterError
void checkDistinct(const std::filesystem::path& output, const std::filesystem::path& other);

/// Check that an output replaces nothing but a regular file. @throws ParameterError
void checkReplaceable(const std::filesystem::path& output);
/// Check that an AtomicFile can be written, before the work that fills it. @throws ParameterError, OutputError
void checkOutput(const std::filesystem::path& output);
/// Check that writeReport() can write there, before the work that fills the report. @throws ParameterError, OutputError
void checkReport(const std::filesystem::path& named);

/// Write a text as an AtomicFile. @throws OutputError naming the file and the system's reason
void writeTextFile(const std::filesystem::path& path, std::string_view text);
/// Write a report: as a text file, or through a pipe or a device, which keeps its name; `-` is standard output.
/// @return whether it is a file  @throws OutputError naming the file and the system's reason; Stopped if a signal ends
/// the wait for a pipe's reader
bool writeReport(const std::filesystem::path& named, std::string_view text);

} // namespace vdblic
