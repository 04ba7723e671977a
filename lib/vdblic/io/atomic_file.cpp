#include "vdblic/io/atomic_file.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/reporter.h"
#include "vdblic/io/checkpoint_mark.h"
#include "vdblic/io/input_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <fcntl.h>
#include <fstream>
#include <string>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace vdblic {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const char* what)
{
    throw OutputError(fmt::format("{}: {}: {}", path.string(), what, std::generic_category().message(errno)));
}

/// Whether a path is a standard stream of this process, a pipe, a device or a socket, which no renamed file can
/// replace.
bool isStream(const std::filesystem::path& path)
{
    struct stat there {
    }, stream{};
    if (::stat(path.c_str(), &there) != 0 || S_ISDIR(there.st_mode)) return false;
    if (!S_ISREG(there.st_mode)) return true;
    for (const int descriptor : {STDOUT_FILENO, STDERR_FILENO}) {
        if (::fstat(descriptor, &stream) == 0 && stream.st_dev == there.st_dev && stream.st_ino == there.st_ino)
            return true;
    }
    return false;
}

constexpr const char* kStandardOutput = "/dev/stdout";

/// Where a report goes: `-` is standard output.
std::filesystem::path reportPath(const std::filesystem::path& report)
{
    return report == "-" ? kStandardOutput : report;
}

/// The file that an output replaces or makes: the one at the end of its symbolic links, which need not exist.
/// @throws ParameterError if something other than a regular file is there
std::filesystem::path fileBehind(const std::filesystem::path& output)
{
    std::error_code error;
    if (std::filesystem::is_directory(output, error)) {
        throw ParameterError(fmt::format("output '{}' is a folder; name a file", output.string()));
    }
    if (isStream(output)) {
        throw ParameterError(
            fmt::format("output '{}' is a device or a pipe, which a file would replace; name a file", output.string()));
    }
    constexpr int kMostLinks = 40; // as many as Linux follows
    std::filesystem::path path = output;
    for (int i = 0; i < kMostLinks && std::filesystem::is_symlink(path, error); ++i)
        path = path.parent_path() / std::filesystem::read_symlink(path, error);
    return path;
}

std::filesystem::path folderOf(const std::filesystem::path& path)
{
    return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

/// Flush a folder to disk. A file system that cannot do so is no error.
void flushFolder(const std::filesystem::path& folder)
{
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return;
    (void)::fsync(descriptor);
    ::close(descriptor);
}

/// Lock a temporary file for as long as it is open. The system frees the lock when the process ends, however it ends.
/// @return false if another writer has locked it. True on file systems without locks, where no file is ever removed.
bool lock(int descriptor)
{
    return ::flock(descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

/// Whether an open file still has the name under which it was opened.
bool isAt(const std::filesystem::path& path, int descriptor)
{
    struct stat named {
    }, open{};
    return ::lstat(path.c_str(), &named) == 0 && ::fstat(descriptor, &open) == 0 && named.st_dev == open.st_dev &&
           named.st_ino == open.st_ino;
}

/// Remove a temporary file that no living process has locked. @return whether there was one that could be opened
bool removeIfDead(const std::filesystem::path& path)
{
    const int descriptor = ::open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (descriptor < 0) return false;
    // The name cannot pass to another file in between: only the holder of the lock renames or removes the file.
    if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0 && isAt(path, descriptor)) ::unlink(path.c_str());
    ::close(descriptor);
    return true;
}

/// The host's name, a part of temporary names: on NFS without locks, a lock holds on its host only.
std::string hostName()
{
    std::array<char, 65> name{}; // Linux allows 64 characters
    if (::gethostname(name.data(), name.size() - 1) != 0) return "host";
    std::replace(name.begin(), name.end(), '/', '_');
    return name.data();
}

/// The temporary names of an output on this host, by number.
std::filesystem::path temporaryName(const std::filesystem::path& final, int number)
{
    constexpr std::size_t kLongest = 120; // leaves room for the rest in the 255 bytes of a file name
    const std::string name = final.filename().string().substr(0, kLongest);
    return folderOf(final) / fmt::format(".{}.{}-{}.part", name, hostName(), number);
}

/// Write to the descriptor of standard output: its name would open whatever has replaced a closed one.
void writeToStandardOutput(std::string_view text)
{
    while (!text.empty()) {
        const ssize_t count = ::write(STDOUT_FILENO, text.data(), text.size());
        if (count < 0 && errno == EINTR) throw Stopped{}; // interrupted while waiting for the reader
        if (count < 0) fail("standard output", "cannot be written");
        text.remove_prefix(std::size_t(count));
    }
}

/// Remove dead processes' temporary files, from a number up to the first one without a file.
void removeLeftovers(const std::filesystem::path& final, int number)
{
    while (removeIfDead(temporaryName(final, number)))
        ++number;
}

/// Choose the first temporary name of an output without a living owner, and remove the files of dead processes.
/// @param create makes the file; false with EEXIST if the name is taken
template<typename Create>
std::filesystem::path takeName(const std::filesystem::path& final, const Create& create)
{
    constexpr int kMostWriters = 1000;
    int number = 0;
    for (;; ++number) {
        removeIfDead(temporaryName(final, number));
        if (create(temporaryName(final, number))) break;
        if (errno != EEXIST || number == kMostWriters) fail(final, "cannot be written");
    }
    removeLeftovers(final, number + 1);
    return temporaryName(final, number);
}

} // namespace

void removeLeftovers(const std::filesystem::path& output)
{
    removeLeftovers(fileBehind(output), 0);
}

bool isFinished(const std::filesystem::path& output)
{
    std::error_code ignored;
    return std::filesystem::is_regular_file(output, ignored);
}

AtomicFile::AtomicFile(const std::filesystem::path& final, Temporary kind) : mFinal(fileBehind(final))
{
    std::error_code ignored;
    const std::filesystem::path folder = folderOf(mFinal);
    if (!std::filesystem::is_directory(folder, ignored)) {
        throw OutputError(
            fmt::format("{}: the folder {} does not exist; make it first", mFinal.string(), folder.string()));
    }
    if (kind == Temporary::kUnnamedIfPossible) {
        mDescriptor = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
        mTemporary = fmt::format("/proc/self/fd/{}", mDescriptor);
        mUnnamed = mDescriptor >= 0 && ::access(mTemporary.c_str(), W_OK) == 0 && lock(mDescriptor);
        if (mUnnamed) return;
        if (mDescriptor >= 0) ::close(mDescriptor); // no /proc
    }
    mNamed = mTemporary = takeName(mFinal, [&](const std::filesystem::path& name) {
        mDescriptor = ::open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (mDescriptor < 0) return false;
        if (lock(mDescriptor) && isAt(name, mDescriptor)) return true;
        ::close(mDescriptor); // another writer removed it before it was locked
        errno = EEXIST;
        return false;
    });
}

AtomicFile::~AtomicFile()
{
    if (mDescriptor < 0) return;
    if (!mUnnamed) ::unlink(mNamed.c_str());
    ::close(mDescriptor);
}

void AtomicFile::commit()
{
    if (::fsync(mDescriptor) != 0) fail(mFinal, "cannot be flushed to disk");
    const auto give = [&](const std::filesystem::path& name) {
        return ::linkat(AT_FDCWD, mTemporary.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
    };
    if (!mUnnamed || !give(mFinal)) { // a file that is there is replaced
        if (mUnnamed) mNamed = takeName(mFinal, give);
        mUnnamed = false;
        if (::rename(mNamed.c_str(), mFinal.c_str()) != 0) fail(mFinal, "cannot be renamed into place");
    } else {
        removeLeftovers(mFinal, 0);
    }
    ::close(mDescriptor);
    mDescriptor = -1;
    flushFolder(folderOf(mFinal));
}

void checkNotInput(const std::filesystem::path& output, const std::filesystem::path& input)
{
    InputFiles inputs;
    inputs.add(input);
    inputs.check(output);
}

void checkDistinct(const std::filesystem::path& output, const std::filesystem::path& other)
{
    std::error_code ignored;
    const auto whole = [&](const std::filesystem::path& path) {
        return std::filesystem::weakly_canonical(std::filesystem::absolute(path, ignored), ignored);
    };
    if (whole(output) != whole(other)) return;
    throw ParameterError(
        fmt::format("'{}' would be written twice, as two outputs; name another file", output.string()));
}

void checkReplaceable(const std::filesystem::path& output)
{
    if (!isCheckpoint(fileBehind(output))) return;
    throw ParameterError(fmt::format("output '{}' would replace a checkpoint of vdblic_advect; name another file, or "
                                     "remove the checkpoint",
                                     output.string()));
}

void checkOutput(const std::filesystem::path& output)
{
    checkReplaceable(output);
    const AtomicFile writable(output);
}

void checkReport(const std::filesystem::path& named)
{
    const std::filesystem::path report = reportPath(named);
    if (!isStream(report)) return checkOutput(report);
    if (::access(report.c_str(), W_OK) != 0) fail(report, "cannot be written");
}

void writeTextFile(const std::filesystem::path& path, std::string_view text)
{
    AtomicFile output(path);
    errno = 0;
    std::ofstream stream(output.temporary(), std::ios::binary | std::ios::trunc);
    stream << text;
    stream.close();
    if (!stream) fail(path, "cannot be written");
    output.commit();
}

bool writeReport(const std::filesystem::path& named, std::string_view text)
{
    const std::filesystem::path path = reportPath(named);
    if (path == kStandardOutput) {
        writeToStandardOutput(text);
        return false;
    }
    const bool isFile = !isStream(path);
    if (isFile) {
        writeTextFile(path, text);
        return isFile;
    }
    errno = 0;
    std::ofstream stream(path, std::ios::binary | std::ios::app);
    stream << text << std::flush;
    if (!stream && errno == EINTR) throw Stopped{}; // interrupted while waiting for the reader
    if (!stream) fail(path, "cannot be written");
    return isFile;
}

} // namespace vdblic
