#pragma once

#include <filesystem>
#include <string_view>

namespace vdblic {

/// Whether an output is there, and so finished: outputs have their final names only when they are complete.
[[nodiscard]] bool isFinished(const std::filesystem::path& output);

/// An output that appears under its final name complete or not at all.
///
/// Write to temporary(), then commit(): the data is flushed to disk, the file renamed, the folder flushed.
/// Without commit() the destructor removes the temporary file. The temporary name depends only on the final
/// one, so what a killed run leaves behind is overwritten by the next.
class AtomicFile {
  public:
    /// @throws OutputError if the folder does not exist or is not writable, or the final name is a folder
    explicit AtomicFile(std::filesystem::path final);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    [[nodiscard]] const std::filesystem::path& temporary() const { return mTemporary; }

    /// @throws OutputError naming the file and the system's reason; the final name is then as it was
    void commit();

  private:
    std::filesystem::path mFinal, mTemporary;
    bool mCommitted = false;
};

/// Write a text as an AtomicFile. @throws OutputError naming the file and the system's reason
void writeTextFile(const std::filesystem::path& path, std::string_view text);

} // namespace vdblic
