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

/// Flush a file or folder to disk; folders of some file systems cannot be flushed, which is no error.
void flush(const std::filesystem::path& path, bool folder, const std::filesystem::path& final)
{
    const int descriptor = ::open(path.c_str(), folder ? O_RDONLY | O_DIRECTORY : O_RDONLY);
    if (descriptor < 0) {
        if (folder) return;
        fail(final, "cannot be flushed to disk");
    }
    const bool failed = ::fsync(descriptor) != 0 && !folder;
    const int reason = errno;
    ::close(descriptor);
    errno = reason;
    if (failed) fail(final, "cannot be flushed to disk");
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

AtomicFile::AtomicFile(std::filesystem::path final) : mFinal(std::move(final))
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
    mTemporary = folder / fmt::format(".{}.part", mFinal.filename().string());
    const int descriptor = ::open(mTemporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    if (descriptor < 0) fail(mFinal, "cannot be written");
    ::close(descriptor);
}

AtomicFile::~AtomicFile()
{
    if (!mCommitted) ::unlink(mTemporary.c_str());
}

void AtomicFile::commit()
{
    flush(mTemporary, false, mFinal);
    if (::rename(mTemporary.c_str(), mFinal.c_str()) != 0) fail(mFinal, "cannot be renamed into place");
    mCommitted = true;
    flush(folderOf(mFinal), true, mFinal);
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
