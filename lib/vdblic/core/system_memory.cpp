#include "vdblic/core/system_memory.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <fcntl.h>
#include <fstream>
#include <malloc.h>
#include <string>
#include <unistd.h>

namespace vdblic {
namespace {

/// The number at the start of a file; no limit if the file says "max" or does not exist.
std::uint64_t limitIn(const std::string& path)
{
    std::uint64_t bytes = 0;
    return std::ifstream(path) >> bytes ? bytes : UINT64_MAX;
}

} // namespace

ProcessMemory processMemory()
{
    const int statm = ::open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
    if (statm < 0) return {};
    std::array<char, 256> text{};
    const ssize_t length = ::read(statm, text.data(), text.size());
    ::close(statm);
    std::array<std::uint64_t, 6> pages{}; // all, resident, files, code, 0, data
    const char* at = text.data();
    const char* const end = at + std::max(length, ssize_t(0));
    for (std::uint64_t& number : pages) {
        at = std::from_chars(at, end, number).ptr;
        if (at != end) ++at; // a space
    }
    const auto page = std::uint64_t(::sysconf(_SC_PAGESIZE));
    return {pages[1] * page, pages[2] * page, pages[5] * page, pages[0] * page};
}

std::uint64_t freeMemory()
{
    std::ifstream file("/proc/meminfo");
    for (std::string word; file >> word;) {
        std::uint64_t kibibytes = 0;
        if (word == "MemAvailable:" && file >> kibibytes) return kibibytes * 1024;
    }
    return UINT64_MAX;
}

std::uint64_t groupMemoryLimit()
{
    std::uint64_t least = UINT64_MAX;
    std::ifstream groups("/proc/self/cgroup"); // ID:CONTROLLERS:PATH
    for (std::string line; std::getline(groups, line);) {
        const std::size_t first = line.find(':'), second = line.find(':', first + 1);
        if (second == std::string::npos) continue;
        const std::string controllers = line.substr(first + 1, second - first - 1);
        const bool unified = controllers.empty();
        if (!unified && controllers != "memory") continue;
        const std::string root = unified ? "/sys/fs/cgroup" : "/sys/fs/cgroup/memory";
        const char* file = unified ? "/memory.max" : "/memory.limit_in_bytes";
        for (std::string group = line.substr(second + 1);; group.resize(group.rfind('/'))) {
            if (group == "/") group.clear();
            least = std::min(least, limitIn(root + group + file));
            if (group.rfind('/') == std::string::npos) break;
        }
    }
    return least;
}

void limitArenas(std::size_t threads)
{
    ::mallopt(M_ARENA_MAX, int(threads));
}

} // namespace vdblic
