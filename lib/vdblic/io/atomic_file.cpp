#include "vdblic/io/atomic_file.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <cerrno>
#include <fcntl.h>
#include <fstream>
#include <system_error>
#include <unistd.h>

namespace vdblic {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const char* what)
{
    throw OutputError(fmt::format("{}: {}: {}", path.string(), what, std::generic_category().message(errno)));
}

/// Flush a folder to disk; those of some file systems cannot be, which is no error.
void flushFolder(const std::filesystem::path& folder)
{
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return;
    (void)::fsync(descriptor);
    ::close(descriptor);
}

std::filesystem::path folderOf(const std::filesystem::path& path)
{
    return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

} // namespace

bool isFinished(const std::filesystem::path& output)
{
    std::error_code ignored;
    return std::filesystem::is_regular_file(output, ignored);
}

AtomicFile::AtomicFile(std::filesystem::path final, Temporary kind) : mFinal(std::move(final))
{
    std::error_code ignored;
    if (std::filesystem::is_directory(mFinal, ignored)) {
        throw OutputError(fmt::format("{}: is a folder; name a file", mFinal.string()));
    }
    const std::filesystem::path folder = folderOf(mFinal);
    if (!std::filesystem::is_directory(folder, ignored)) {
        throw OutputError(
            fmt::format("{}: the folder {} does not exist; make it first", mFinal.string(), folder.string()));
    }
    mNamed = folder / fmt::format(".{}.part", mFinal.filename().string());
    if (kind == Temporary::kUnnamedIfPossible) {
        mDescriptor = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
        mTemporary = fmt::format("/proc/self/fd/{}", mDescriptor);
        mUnnamed = mDescriptor >= 0 && ::access(mTemporary.c_str(), W_OK) == 0;
        if (mUnnamed) return;
        if (mDescriptor >= 0) ::close(mDescriptor); // no /proc
    }
    mTemporary = mNamed;
    mDescriptor = ::open(mNamed.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (mDescriptor < 0) fail(mFinal, "cannot be written");
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
    if (mUnnamed) {
        ::unlink(mNamed.c_str()); // of a process killed between here and the renaming
        if (::linkat(AT_FDCWD, mTemporary.c_str(), AT_FDCWD, mNamed.c_str(), AT_SYMLINK_FOLLOW) != 0) {
            fail(mFinal, "cannot be given a name");
        }
        mUnnamed = false;
    }
    if (::rename(mNamed.c_str(), mFinal.c_str()) != 0) fail(mFinal, "cannot be renamed into place");
    ::close(mDescriptor);
    mDescriptor = -1;
    flushFolder(folderOf(mFinal));
}

void checkNotInput(const std::filesystem::path& output, const std::filesystem::path& input)
{
    std::error_code ignored;
    if (!std::filesystem::equivalent(output, input, ignored)) return;
    throw ParameterError(fmt::format("output '{}' would replace an input; name another file", output.string()));
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

} // namespace vdblic
