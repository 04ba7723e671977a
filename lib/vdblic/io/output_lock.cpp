#include "vdblic/io/output_lock.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace vdblic {
namespace {

constexpr std::string_view kMark = "vdblic lock: ";

/// Process, host and command, for messages.
std::string nameOfProcess()
{
    std::array<char, 65> host{}; // Linux allows 64 characters
    if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '?';
    std::ifstream stream("/proc/self/cmdline", std::ios::binary);
    std::string command{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    while (command.ends_with('\0'))
        command.pop_back();
    std::replace(command.begin(), command.end(), '\0', ' ');
    constexpr std::size_t kLongest = 200;
    return fmt::format("process {} on {}: {:.{}}", ::getpid(), host.data(), command, kLongest);
}

std::string contentOf(int descriptor)
{
    std::array<char, 1024> bytes{};
    const ssize_t count = ::pread(descriptor, bytes.data(), bytes.size(), 0);
    return {bytes.data(), std::size_t(std::max<ssize_t>(count, 0))};
}

bool hasName(const std::filesystem::path& path, int descriptor)
{
    struct stat named {
    }, open{};
    return ::lstat(path.c_str(), &named) == 0 && ::fstat(descriptor, &open) == 0 && named.st_dev == open.st_dev &&
           named.st_ino == open.st_ino;
}

int openLock(const std::filesystem::path& file)
{
    constexpr int kFlags = O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
    const int made = ::open(file.c_str(), O_RDWR | O_CREAT | kFlags, 0666);
    return made < 0 && errno == EACCES ? ::open(file.c_str(), O_RDONLY | kFlags) : made; // a file of another user
}

} // namespace

OutputLock::OutputLock(std::filesystem::path file, const std::filesystem::path& outputs) : mFile(std::move(file))
{
    for (;;) {
        mDescriptor = openLock(mFile);
        if (mDescriptor < 0) {
            throw OutputError(
                fmt::format("{}: cannot be locked: {}", mFile.string(), std::generic_category().message(errno)));
        }
        struct stat status {};
        const std::string content = contentOf(mDescriptor);
        if (::fstat(mDescriptor, &status) != 0 || !S_ISREG(status.st_mode) ||
            !(content.empty() || content.starts_with(kMark))) {
            ::close(std::exchange(mDescriptor, -1));
            throw OutputError(
                fmt::format("{}: is no lock of a run, which would have this name; move it away", mFile.string()));
        }
        if (::flock(mDescriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
            ::close(std::exchange(mDescriptor, -1));
            throw ParameterError(fmt::format("{}: another run is writing these outputs{}{}; wait for its end, or give "
                                             "another `output`",
                                             outputs.string(), content.empty() ? "" : ", ",
                                             content.substr(std::min(kMark.size(), content.size()))));
        }
        if (hasName(mFile, mDescriptor)) break;
        ::close(std::exchange(mDescriptor, -1)); // the holder has just removed it
    }
    mLitter.emplace(mFile.string());
    const std::string holder = fmt::format("{}{}", kMark, nameOfProcess());
    // The holder's text serves messages only: a failed write is no error.
    if (::ftruncate(mDescriptor, 0) == 0) (void)!::pwrite(mDescriptor, holder.data(), holder.size(), 0);
}

OutputLock::~OutputLock()
{
    mLitter.reset();
    ::unlink(mFile.c_str());
    ::close(mDescriptor);
}

} // namespace vdblic
