#include "vdblic/render/frames_in_flight.h"

#include "vdblic/core/memory.h"
#include "vdblic/core/threads.h"

#include <algorithm>
#include <fstream>
#include <string>

namespace vdblic {
double availableMemory()
{
    const auto limit = double(memoryLimit());
    std::ifstream file("/proc/meminfo");
    std::string word;
    while (file >> word) {
        double kilobytes = 0;
        if (word == "MemAvailable:" && file >> kilobytes) return std::min(kilobytes * 1024, limit);
    }
    return limit;
}

std::size_t framesInFlight(double frameBytes)
{
    return framesInFlight(frameBytes, threadCount(), availableMemory());
}

std::size_t framesInFlight(double frameBytes, std::size_t threads, double freeBytes)
{
    const double fitting = freeBytes / 2 / std::max(frameBytes, 1.0);
    return fitting < double(threads) ? std::max(std::size_t(fitting), std::size_t(1)) : threads;
}

} // namespace vdblic
