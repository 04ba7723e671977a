#include "bench/engine/peak_memory.h"

#include <cstdio>
#include <fcntl.h>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace vdblic::bench {
namespace {

/// Run a tool of the same build. @return its peak resident memory [bytes]
double peakOf(const std::vector<std::string>& command)
{
    const auto tools = std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "tools";
    std::vector<std::string> words = command;
    words[0] = (tools / command[0]).string();
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (std::string& word : words)
        arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const pid_t child = ::fork();
    if (child == 0) {
        ::dup2(::open("/dev/null", O_WRONLY), STDOUT_FILENO);
        ::execv(arguments[0], arguments.data());
        ::_exit(127);
    }
    int status = 0;
    rusage usage{};
    ::wait4(child, &status, 0, &usage);
    if (status != 0) throw std::runtime_error(command[0] + " failed");
    return 1024.0 * double(usage.ru_maxrss);
}

} // namespace

nlohmann::json measurePeakMemory()
{
    std::printf("\nPeak memory of vdblic_advect, whole process, 4 frames\n\n| | bytes per active voxel |\n|---|---|\n");
    const auto folder = std::filesystem::temp_directory_path() / ("vdblic_bench_" + std::to_string(::getpid()));
    std::filesystem::create_directory(folder);
    nlohmann::json rows;
    for (const int side : {64, 128, 256}) {
        const std::string size = std::to_string(side), velocity = (folder / "velocity.%04d.vdb").string();
        (void)peakOf({"vdblic_synth", "abc", "-q", "-o", velocity, "--size", size, size, size, "--frames", "1-4"});
        const double bytes = peakOf({"vdblic_advect", velocity, "-q", "-o", (folder / "lic.%04d.vdb").string()});
        const double perVoxel = bytes / (double(side) * side * side);
        std::printf("| %d cubed | %.0f |\n", side, perVoxel);
        std::fflush(stdout);
        rows.push_back({{"side", side}, {"bytes_per_voxel", perVoxel}});
    }
    std::filesystem::remove_all(folder);
    return rows;
}

} // namespace vdblic::bench
