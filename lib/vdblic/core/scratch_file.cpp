#include "vdblic/core/scratch_file.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fcntl.h>
#include <linux/fs.h>
#include <string>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <system_error>
#include <unistd.h>

namespace vdblic {
namespace {

[[noreturn]] void refuseScratch(const std::filesystem::path& folder, int reason)
{
    throw OutputError(fmt::format("{}: no scratch file can be made there: {}; give another folder with `scratch`",
                                  folder.string(), std::generic_category().message(reason)));
}

/// An open file without a name; unlinked at once where the file system has no unnamed files.
int openUnnamed(const std::filesystem::path& folder)
{
    const int unnamed = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (unnamed >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL)) return unnamed;
    std::string path = (folder / ".vdblic-scratch.XXXXXX").string();
    const int named = ::mkostemp(path.data(), O_CLOEXEC);
    if (named >= 0) ::unlink(path.c_str());
    return named;
}

/// Turn off copy-on-write. Btrfs otherwise writes changed pages to new blocks, which a full disk lacks.
void writeInPlace(int descriptor)
{
    int flags = 0;
    if (::ioctl(descriptor, FS_IOC_GETFLAGS, &flags) != 0) return; // a file system without such flags
    flags |= FS_NOCOW_FL;
    (void)::ioctl(descriptor, FS_IOC_SETFLAGS, &flags);
}

} // namespace

ScratchFile::ScratchFile(const std::filesystem::path& folder, bool readsAhead) : mDescriptor(openUnnamed(folder))
{
    if (mDescriptor < 0) refuseScratch(folder, errno);
    writeInPlace(mDescriptor);
    std::error_code ignored;
    constexpr std::size_t kMost = std::size_t(1) << 40, kLeast = std::size_t(1) << 30;
    mCapacity = std::clamp(std::size_t(std::filesystem::space(folder, ignored).available), kLeast, kMost);
    mCapacity &= ~((std::size_t(1) << 20) - 1);
    void* const begin = ::mmap(nullptr, mCapacity, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_NORESERVE, mDescriptor, 0);
    if (begin == MAP_FAILED) {
        const int reason = errno;
        ::close(mDescriptor);
        refuseScratch(folder, reason);
    }
    mBegin = static_cast<char*>(begin);
    if (!readsAhead) ::madvise(mBegin, mCapacity, MADV_RANDOM);
}

ScratchFile::~ScratchFile()
{
    ::munmap(mBegin, mCapacity);
    ::close(mDescriptor);
}

int ScratchFile::grow(std::size_t size) noexcept
{
    if (size <= mSize) return 0;
    if (size > mCapacity) return ENOSPC;
    int reason = EINTR;
    while (reason == EINTR)
        reason = ::posix_fallocate(mDescriptor, ::off_t(mSize), ::off_t(size - mSize));
    if (reason == 0) mSize = size;
    return reason;
}

void ScratchFile::letGo(std::size_t begin, std::size_t bytes) const noexcept
{
    ::madvise(mBegin + begin, bytes, MADV_DONTNEED);
}

void ScratchFile::discard(std::size_t begin, std::size_t bytes) const noexcept
{
    // File systems without this operation write the contents needlessly.
    if (::fallocate(mDescriptor, FALLOC_FL_ZERO_RANGE | FALLOC_FL_KEEP_SIZE, ::off_t(begin), ::off_t(bytes)) != 0)
        letGo(begin, bytes);
}

} // namespace vdblic
