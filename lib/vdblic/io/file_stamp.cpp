#include "vdblic/io/file_stamp.h"

#include "vdblic/io/vdb_layout.h"

#include <fmt/chrono.h>

#include <cstddef>
#include <fstream>
#include <sys/stat.h>
#include <vector>

namespace vdblic {
namespace {

std::string identityIn(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    file.seekg(VdbLayout::kIdentityOffset);
    std::string identity(VdbLayout::kIdentityLength, '\0');
    const bool found = file.read(identity.data(), std::streamsize(identity.size())) &&
                       identity.find_first_not_of("0123456789abcdef-") == std::string::npos;
    return found ? identity : "none";
}

std::vector<std::string_view> partsOf(std::string_view stamp)
{
    constexpr std::string_view kBetween = ", ";
    std::vector<std::string_view> parts;
    while (true) {
        const std::size_t end = stamp.find(kBetween);
        parts.push_back(stamp.substr(0, end));
        if (end == std::string_view::npos) return parts;
        stamp.remove_prefix(end + kBetween.size());
    }
}

} // namespace

std::string fileStamp(const std::filesystem::path& path)
{
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return "missing";
    const bool regular = S_ISREG(status.st_mode); // reading a pipe or device may block
    return fmt::format("size {}, modified {:%F %T}.{:09} UTC, identity {}", status.st_size,
                       fmt::gmtime(status.st_mtim.tv_sec), status.st_mtim.tv_nsec, regular ? identityIn(path) : "none");
}

std::string stampDifference(std::string_view then, std::string_view now)
{
    const std::vector<std::string_view> before = partsOf(then), after = partsOf(now);
    if (before.size() != after.size()) return fmt::format("then {}; now {}", then, now);
    std::string text;
    for (std::size_t i = 0; i < before.size(); ++i) {
        if (before[i] == after[i]) continue;
        text += fmt::format("{}then {}, now {}", text.empty() ? "" : "; ", before[i], after[i]);
    }
    return text;
}

} // namespace vdblic
