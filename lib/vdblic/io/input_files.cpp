#include "vdblic/io/input_files.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <optional>
#include <sys/stat.h>

namespace vdblic {
namespace {

std::optional<std::pair<dev_t, ino_t>> identityOf(const std::filesystem::path& path)
{
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return std::nullopt;
    return std::pair{status.st_dev, status.st_ino};
}

} // namespace

void InputFiles::add(const std::filesystem::path& input)
{
    if (const auto identity = identityOf(input)) mFiles.insert(*identity);
}

void InputFiles::check(const std::filesystem::path& output) const
{
    const auto identity = identityOf(output);
    if (!identity || !mFiles.contains(*identity)) return;
    throw ParameterError(fmt::format("output '{}' would replace an input; name another file", output.string()));
}

} // namespace vdblic
