#include "vdblic/core/free_runs.h"

#include <bit>
#include <new>
#include <sys/mman.h>

namespace vdblic {
namespace {

std::size_t listOf(std::uint32_t count)
{
    return std::size_t(std::bit_width(count)) - 1;
}

} // namespace

FreeRuns::FreeRuns(std::size_t places) : mPlaces(places)
{
    void* const table = ::mmap(nullptr, places * sizeof(Place), PROT_READ | PROT_WRITE,
                               MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (table == MAP_FAILED) throw std::bad_alloc();
    mTable = static_cast<Place*>(table);
    mFirst.fill(kNone);
}

FreeRuns::~FreeRuns()
{
    ::munmap(mTable, mPlaces * sizeof(Place));
}

void FreeRuns::link(Range range)
{
    std::uint32_t& head = mFirst[listOf(range.count)];
    mTable[range.first] = {range.count, kNone, head};
    mTable[range.first + range.count - 1].count = range.count;
    if (head != kNone) mTable[head].before = range.first;
    head = range.first;
}

void FreeRuns::unlink(Range range)
{
    Place& place = mTable[range.first];
    (place.before == kNone ? mFirst[listOf(range.count)] : mTable[place.before].after) = place.after;
    if (place.after != kNone) mTable[place.after].before = place.before;
    place.count = mTable[range.first + range.count - 1].count = 0;
}

void FreeRuns::add(Range range)
{
    if (range.first > 0) {
        if (const std::uint32_t count = mTable[range.first - 1].count; count > 0) {
            const Range left{range.first - count, count};
            unlink(left);
            range = {left.first, left.count + range.count};
        }
    }
    if (const std::size_t end = std::size_t(range.first) + range.count; end < mPlaces) {
        if (const Range right{std::uint32_t(end), mTable[end].count}; right.count > 0) {
            unlink(right);
            range.count += right.count;
        }
    }
    link(range);
}

std::optional<std::uint32_t> FreeRuns::take(std::uint32_t count)
{
    constexpr int kMostTries = 64; // in the list whose ranges may be too short
    std::size_t list = listOf(count);
    std::uint32_t found = mFirst[list];
    for (int tries = 0; found != kNone && mTable[found].count < count; ++tries)
        found = tries < kMostTries ? mTable[found].after : kNone;
    while (found == kNone && ++list < kLists)
        found = mFirst[list];
    if (found == kNone) return std::nullopt;
    const Range range{found, mTable[found].count};
    unlink(range);
    if (range.count > count) link({range.first + count, range.count - count});
    return found;
}

std::optional<FreeRuns::Range> FreeRuns::takeAny()
{
    for (const std::uint32_t first : mFirst) {
        if (first == kNone) continue;
        const Range range{first, mTable[first].count};
        unlink(range);
        return range;
    }
    return std::nullopt;
}

} // namespace vdblic
