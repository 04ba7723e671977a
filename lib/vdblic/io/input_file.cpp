#include "vdblic/io/input_file.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <system_error>

namespace vdblic {

void checkRegular(const std::filesystem::path& path)
{
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status) || std::filesystem::is_regular_file(status)) return;
    throw InputError(fmt::format("{}: is no regular file; an input must be one", path.string()));
}

bool isFile(const std::filesystem::path& path)
{
    std::error_code ignored;
    return std::filesystem::exists(path, ignored) && !std::filesystem::is_directory(path, ignored);
}

} // namespace vdblic
