#include "vdblic/core/paged_heap.h"

#include <algorithm>
#include <bit>
#include <new>
#include <optional>
#include <sys/mman.h>

namespace vdblic {
namespace {

// Free runs kept resident for reuse; pages of further ones are discarded, so never written.
constexpr std::size_t kMostWarm = 64;
constexpr std::size_t kGrowth = std::size_t(64) << 20; // bytes by which the file grows

std::atomic<std::size_t> gThreads = 0;

/// A number of this thread.
std::size_t threadNumber()
{
    thread_local const std::size_t number = gThreads++;
    return number;
}

} // namespace

PagedHeap::PagedHeap(ScratchFile& file)
    : mFile(file), mBegin(file.begin()), mEnd(file.begin() + file.capacity()),
      mUse(new std::atomic<Use>[file.capacity() / kRun]()), mShelves(new Shelf[kShards * kSizes]),
      mWarm(file.capacity() / kRun), mEmpty(file.capacity() / kRun)
{
    void* const runs = ::mmap(nullptr, file.capacity() / kRun * sizeof(Run), PROT_READ | PROT_WRITE,
                              MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (runs == MAP_FAILED) throw std::bad_alloc();
    mRuns = static_cast<Run*>(runs);
}

PagedHeap::~PagedHeap()
{
    ::munmap(mRuns, mFile.capacity() / kRun * sizeof(Run));
}

/// Size classes: steps of 16 bytes, then eighths of a power of two.
std::size_t PagedHeap::sizeNumber(std::size_t bytes)
{
    if (bytes <= kFine) return (std::max(bytes, kLeast) - kLeast + kFineStep - 1) / kFineStep;
    const std::size_t octave = std::size_t(std::bit_width(bytes - 1)) - std::size_t(std::bit_width(kFine));
    const std::size_t base = kFine << octave, step = base / kSteps;
    return (kFine - kLeast) / kFineStep + octave * kSteps + (bytes - base + step - 1) / step;
}

std::size_t PagedHeap::sizeOf(std::size_t number)
{
    constexpr std::size_t kFines = (kFine - kLeast) / kFineStep;
    if (number <= kFines) return kLeast + number * kFineStep;
    const std::size_t coarse = number - kFines - 1, base = kFine << (coarse / kSteps);
    return base + (coarse % kSteps + 1) * (base / kSteps);
}

void PagedHeap::prepend(List& list, std::uint32_t run)
{
    mRuns[run].before = kNone;
    mRuns[run].after = list.first;
    (list.first == kNone ? list.last : mRuns[list.first].before) = run;
    list.first = run;
}

void PagedHeap::append(List& list, std::uint32_t run)
{
    mRuns[run].after = kNone;
    mRuns[run].before = list.last;
    (list.last == kNone ? list.first : mRuns[list.last].after) = run;
    list.last = run;
}

void PagedHeap::remove(List& list, std::uint32_t run)
{
    const Run& of = mRuns[run];
    (of.before == kNone ? list.first : mRuns[of.before].after) = of.after;
    (of.after == kNone ? list.last : mRuns[of.after].before) = of.before;
}

int PagedHeap::reserve(std::size_t bytes) noexcept
{
    const std::lock_guard lock(mMutex);
    return mFile.grow(bytes);
}

/// The first of `count` consecutive free runs, or kNone.
std::uint32_t PagedHeap::takeFree(std::size_t count) noexcept
{
    const auto number = std::uint32_t(count);
    if (const std::optional<std::uint32_t> first = mWarm.take(number)) {
        mWarmRuns -= count;
        return *first;
    }
    if (const std::optional<std::uint32_t> first = mEmpty.take(number)) return *first;
    if (mWarmRuns == 0) return kNone;
    // Together with empty neighbours, warm runs may suffice.
    while (const std::optional<FreeRuns::Range> range = mWarm.takeAny()) {
        mFile.discard(range->first * kRun, range->count * kRun);
        mEmpty.add(*range);
    }
    mWarmRuns = 0;
    return mEmpty.take(number).value_or(kNone);
}

std::uint32_t PagedHeap::takeRuns(std::size_t count, Use use) noexcept
{
    const std::lock_guard lock(mMutex);
    std::uint32_t first = takeFree(count);
    if (first == kNone) {
        const std::size_t end = (mTop + count) * kRun;
        if (end > mFile.size() && mFile.grow(end + kGrowth) != 0) {
            if (const int reason = mFile.grow(end); reason != 0) {
                mProblem = reason;
                return kNone;
            }
        }
        first = std::uint32_t(mTop);
        mTop += count;
    }
    for (std::size_t run = first; run < first + count; ++run)
        mUse[run] = use;
    return first;
}

void PagedHeap::giveBack(std::uint32_t first, std::size_t count) noexcept
{
    std::unique_lock lock(mMutex);
    const bool staysWarm = mWarmRuns + count <= kMostWarm;
    if (!staysWarm) {
        lock.unlock(); // no other thread can reach the runs
        mFile.discard(first * kRun, count * kRun);
        lock.lock();
    }
    for (std::size_t run = first; run < first + count; ++run)
        mUse[run] = Use::kFree;
    (staysWarm ? mWarm : mEmpty).add({first, std::uint32_t(count)});
    mWarmRuns += staysWarm ? count : 0;
}

void* PagedHeap::allocate(std::size_t bytes) noexcept
{
    if (bytes > kRun / 2) {
        const std::size_t count = (bytes + kRun - 1) / kRun;
        if (count > mFile.capacity() / kRun) return nullptr;
        const std::uint32_t first = takeRuns(count, Use::kLarge);
        if (first == kNone) return nullptr;
        mRuns[first].size = std::uint32_t(count);
        return place(first, 0);
    }
    const std::size_t size = sizeNumber(bytes), shard = threadNumber() % kShards;
    Shelf& of = shelf(shard, size);
    const std::lock_guard lock(of.mutex);
    if (of.runs.first == kNone) {
        const std::uint32_t taken = takeRuns(1, Use::kObjects);
        if (taken == kNone) return nullptr;
        Run& run = mRuns[taken];
        run.size = std::uint32_t(size);
        run.shard = std::uint32_t(shard);
        run.capacity = std::uint32_t(kRun / sizeOf(size));
        run.used = run.firstFree = 0;
        for (std::size_t word = 0; word <= run.capacity / kWord; ++word)
            run.taken[word] = 0;
        run.taken[run.capacity / kWord] = ~std::uint64_t(0) << run.capacity % kWord; // no places beyond the capacity
        prepend(of.runs, taken);
    }
    const std::uint32_t number = of.runs.first;
    Run& run = mRuns[number];
    while (run.taken[run.firstFree] == ~std::uint64_t(0))
        ++run.firstFree;
    std::uint64_t& word = run.taken[run.firstFree];
    const auto bit = std::size_t(std::countr_one(word));
    word |= std::uint64_t(1) << bit;
    if (++run.used == run.capacity) remove(of.runs, number);
    return place(number, (run.firstFree * kWord + bit) * sizeOf(size));
}

std::size_t PagedHeap::release(void* memory) noexcept
{
    const auto offset = std::size_t(static_cast<char*>(memory) - mBegin);
    const auto number = std::uint32_t(offset / kRun);
    Run& run = mRuns[number];
    if (mUse[number] == Use::kLarge) {
        const std::size_t count = run.size;
        giveBack(number, count);
        return count * kRun;
    }
    const std::size_t bytes = sizeOf(run.size), object = offset % kRun / bytes;
    Shelf& of = shelf(run.shard, run.size);
    {
        const std::lock_guard lock(of.mutex);
        run.taken[object / kWord] &= ~(std::uint64_t(1) << object % kWord);
        run.firstFree = std::min(run.firstFree, std::uint32_t(object / kWord));
        if (run.used-- == run.capacity) append(of.runs, number);
        const bool isOnlyOne = of.runs.first == of.runs.last;
        if (run.used > 0 || isOnlyOne) return bytes;
        remove(of.runs, number);
    }
    giveBack(number, 1);
    return bytes;
}

void PagedHeap::letGo(std::size_t first, std::size_t count) const noexcept
{
    const std::size_t end = std::min(first + count, runs());
    if (first < end) mFile.letGo(first * kRun, (end - first) * kRun);
}

} // namespace vdblic
