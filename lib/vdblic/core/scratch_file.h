#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace vdblic {

/// A file without a name, mapped into the process as one range of addresses. Nothing stays of it after the process.
/// Only letGo() and discard() may be called by several threads.
class ScratchFile {
  public:
    /// @param readsAhead whether the system may map neighbouring pages too, which makes resident memory jump
    /// @throws OutputError naming the folder and the reason
    ScratchFile(const std::filesystem::path& folder, bool readsAhead);
    ~ScratchFile();
    ScratchFile(const ScratchFile&) = delete;
    ScratchFile& operator=(const ScratchFile&) = delete;

    [[nodiscard]] char* begin() const { return mBegin; }
    [[nodiscard]] std::size_t capacity() const { return mCapacity; } ///< bytes that it may grow to
    [[nodiscard]] std::size_t size() const { return mSize; }         ///< bytes allocated on disk

    /// Grow the file on disk to `size`. @return 0, or an errno
    [[nodiscard]] int grow(std::size_t size) noexcept;

    /// Evict a range from resident memory; its contents stay in the file.
    void letGo(std::size_t begin, std::size_t bytes) const noexcept;
    /// Discard the contents of a range, so that they are never written. Its blocks stay allocated.
    void discard(std::size_t begin, std::size_t bytes) const noexcept;

  private:
    int mDescriptor = -1;
    char* mBegin = nullptr;
    std::size_t mCapacity = 0, mSize = 0;
};

} // namespace vdblic
