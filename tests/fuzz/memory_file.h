#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <sys/mman.h>
#include <unistd.h>

namespace vdblic {

/// A file in memory.
class MemoryFile {
  public:
    MemoryFile(const std::uint8_t* data, std::size_t size) : mFile(::memfd_create("fuzz", 0))
    {
        if (mFile < 0 || ::write(mFile, data, size) != ssize_t(size)) std::abort();
    }
    ~MemoryFile() { ::close(mFile); }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;

    [[nodiscard]] std::filesystem::path path() const { return "/proc/self/fd/" + std::to_string(mFile); }

  private:
    int mFile;
};

} // namespace vdblic
