#include "vdblic/core/memory.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/paging.h"
#include "vdblic/core/system_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <sys/resource.h>
#include <system_error>
#include <unistd.h>

namespace vdblic {
namespace {

std::atomic<bool> gHasOption = false;

/// The process's limit on a resource [bytes]; no limit if it has none.
std::uint64_t limitOn(int resource)
{
    rlimit own{};
    const bool isLimited = ::getrlimit(resource, &own) == 0 && own.rlim_cur != RLIM_INFINITY;
    return isLimited ? std::uint64_t(own.rlim_cur) : UINT64_MAX;
}

} // namespace

std::uint64_t machineMemory()
{
    return std::min(std::uint64_t(::sysconf(_SC_PHYS_PAGES)) * std::uint64_t(::sysconf(_SC_PAGESIZE)),
                    groupMemoryLimit());
}

std::uint64_t memoryLimit()
{
    return std::min({machineMemory(), limitOn(RLIMIT_DATA), limitOn(RLIMIT_AS)});
}

void setMemoryOption()
{
    gHasOption = true;
}

bool hasMemoryOption()
{
    return gHasOption;
}

std::uint64_t parseMemory(std::string_view text)
{
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed);
    const std::string_view unit = text.substr(std::size_t(end - text.data()));
    constexpr std::string_view kUnits = "KMGT", kSmall = "kmgt";
    if (!unit.empty()) {
        const std::size_t power = std::min(kUnits.find(unit[0]), kSmall.find(unit[0]));
        number = power == std::string_view::npos || unit.size() > 1 ? 0 : std::ldexp(number, 10 * int(power + 1));
    }
    constexpr auto kMost = double(std::uint64_t(1) << 50);
    if (error != std::errc{} || !(number >= 1 && number <= kMost)) {
        throw ParameterError(fmt::format("'{:.60}' is no size of memory; give one such as 800M or 16G", text));
    }
    return std::uint64_t(number);
}

std::string memoryText(double bytes)
{
    constexpr std::array<const char*, 5> kUnits = {"B", "KiB", "MiB", "GiB", "TiB"};
    std::size_t unit = 0;
    for (; bytes >= 1024 && unit + 1 < kUnits.size(); ++unit)
        bytes /= 1024;
    return fmt::format("{:.{}f} {}", bytes, unit == 0 ? 0 : 1, kUnits[unit]);
}

std::string_view memoryMend()
{
    return gHasOption ? "raise `max_memory`" : "give the process more memory";
}

void checkMemory(double needed, const std::string& what, const std::string& mend)
{
    const auto limit = double(memoryLimit());
    if (needed <= limit) return;
    throw InputError(fmt::format("{} would take {} of memory or more, and {} may be used: {}, or {}", what,
                                 memoryText(needed), memoryText(limit), mend, memoryMend()));
}

void checkVoxels(std::uint64_t count, const std::string& where, int ranks, std::uint64_t stored)
{
    constexpr double kLeast = 16; // bytes per voxel
    if (kLeast * double(count - stored) / ranks <= double(memoryLimit()) && paging::mayHold(kLeast * double(count)))
        return;
    checkMemory(double(count) / ranks * kLeast, fmt::format("{}{}{} voxels", where, where.empty() ? "" : ": ", count),
                "cut the domain with `box` or `mask`");
}

} // namespace vdblic
