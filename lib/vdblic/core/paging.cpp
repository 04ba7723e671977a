#include "vdblic/core/paging.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/paged_heap.h"
#include "vdblic/core/scratch_file.h"
#include "vdblic/core/system_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <new>
#include <optional>
#include <pthread.h>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

namespace vdblic::paging {
namespace {

constexpr double kNear = 0.8;                              // estimates are a quarter wrong at most
constexpr std::uint64_t kLarge = std::uint64_t(512) << 20; // a limit that large pages do not soon exceed
constexpr double kSpread = 1.25;                           // what a file takes for what is in it: runs have gaps

// Of the process, and never destroyed: memory is freed until its very end.
std::atomic<bool> gIsLent = false;
std::atomic<PagedHeap*> gHeap = nullptr;
std::array<char, 4600> gProblem{}; // what it would be but for the reason
std::atomic<bool> gHasProblem = false;
struct Offer {
    std::filesystem::path folder;
    std::uint64_t limit = 0;
    double inFiles = 0;
};
std::optional<Offer> gOffer;
std::mutex gMutex; // of the offer, and of the beginning

/// Keeps the process's resident memory below a limit.
///
/// Runs leave the memory round and round in the order in which they lie in the file. The few that are in use come back
/// from the system's cache at once; the others were used longest ago, because work sweeps over all that there is.
class Keeper {
  public:
    Keeper(const PagedHeap& heap, std::uint64_t limit)
        : mHeap(heap), mMost(limit - limit / 8 - kLate), mStep(limit / 16), mCode(processMemory().files)
    {
    }

    void keep()
    {
        if (!isTooMuch(processMemory(), 0)) return;
        const std::lock_guard lock(mMutex);
        constexpr std::size_t kTogether = 4; // runs
        for (std::size_t passed = 0; isTooMuch(processMemory(), mStep) && passed < mHeap.runs(); passed += kTogether) {
            mHeap.letGo(mNext, kTogether);
            mNext = mNext + kTogether < mHeap.runs() ? mNext + kTogether : 0;
        }
    }

    /// For what threads take without breathing: for ever.
    void watch()
    {
        for (;;) {
            keep();
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }

  private:
    static constexpr std::uint64_t kLate = std::uint64_t(24) << 20;  // what may come before letting go begins
    static constexpr std::uint64_t kLeast = std::uint64_t(16) << 20; // of scratch, whatever else there is

    [[nodiscard]] bool isTooMuch(const ProcessMemory& now, std::uint64_t step) const
    {
        return now.resident + step > mMost && now.files > mCode + kLeast;
    }

    const PagedHeap& mHeap;
    std::uint64_t mMost, mStep, mCode;
    std::mutex mMutex;
    std::size_t mNext = 0; // run to let go
};
std::atomic<Keeper*> gKeeper = nullptr;

/// Start the thread that watches. It takes no signals, and little of the limit on data by its stack.
/// @return 0, or the system's reason why it cannot be started
int startWatching(Keeper& keeper)
{
    sigset_t all, before;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before);
    pthread_attr_t attributes;
    ::pthread_attr_init(&attributes);
    ::pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
    ::pthread_attr_setstacksize(&attributes, std::size_t(1) << 18);
    pthread_t thread{};
    const auto watch = [](void* of) -> void* {
        static_cast<Keeper*>(of)->watch();
        return nullptr;
    };
    const int reason = ::pthread_create(&thread, &attributes, watch, &keeper);
    ::pthread_attr_destroy(&attributes);
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
    return reason;
}

/// On the disk; 0 if that is not known.
std::uintmax_t freeBytes(const Offer& offered)
{
    std::error_code error;
    const std::filesystem::space_info space = std::filesystem::space(offered.folder, error);
    return error ? 0 : space.available;
}

/// @return the heap  @param offered under the lock
PagedHeap& begin(const Offer& offered)
{
    if (PagedHeap* const heap = gHeap) return *heap;
    const bool readsAhead = offered.limit >= kLarge;
    auto* const heap = new PagedHeap(*new ScratchFile(offered.folder, readsAhead)); // all for ever
    auto* const keeper = new Keeper(*heap, offered.limit);
    std::snprintf(gProblem.data(), gProblem.size(), "%s", offered.folder.c_str());
    if (startWatching(*keeper) != 0) throw std::bad_alloc();
    gKeeper = keeper;
    gHeap = heap;
    return *heap;
}

/// @param reached bytes that the file has
void noteProblem(int reason, std::size_t reached) noexcept
{
    static std::mutex once;
    const std::lock_guard lock(once);
    if (gHasProblem) return;
    const std::size_t length = std::strlen(gProblem.data());
    std::snprintf(gProblem.data() + length, gProblem.size() - length,
                  ": the scratch file cannot grow beyond %zu MiB: %s; make room, or give another folder with --scratch",
                  reached >> 20, ::strerrordesc_np(reason));
    gHasProblem = true;
}

} // namespace

void lend()
{
    gIsLent = true;
}

bool isLent()
{
    return gIsLent;
}

void offer(const std::filesystem::path& folder, std::uint64_t limit, double inFiles)
{
    const std::lock_guard lock(gMutex);
    if (gIsLent) gOffer = {folder, limit, inFiles};
}

bool makeRoom(double bytes)
{
    const std::lock_guard lock(gMutex);
    if (!gOffer || (!gHeap && bytes <= kNear * double(gOffer->limit))) return false;
    const double size = kSpread * bytes;
    if (const int reason = begin(*gOffer).reserve(std::size_t(size)); reason != 0) {
        throw OutputError(fmt::format("{}: there is no room for a scratch file of {}, and {} are free: {}; make room, "
                                      "or give another folder with `scratch`",
                                      gOffer->folder.string(), memoryText(size), memoryText(double(freeBytes(*gOffer))),
                                      std::generic_category().message(reason)));
    }
    return true;
}

void expectFiles(double bytes)
{
    const std::lock_guard lock(gMutex);
    constexpr double kTool = 40e6; // what a tool takes by itself
    if (gOffer && kTool + gOffer->inFiles * bytes > kNear * double(gOffer->limit)) begin(*gOffer);
}

bool mayHold(double bytes)
{
    const std::lock_guard lock(gMutex);
    if (!gOffer) return false;
    return bytes <= double(gOffer->limit) + double(freeBytes(*gOffer));
}

void breathe(std::size_t bytes)
{
    Keeper* const keeper = gKeeper.load(std::memory_order_acquire);
    if (__builtin_expect(!keeper, 1)) return;
    constexpr std::size_t kBreath = std::size_t(1) << 19;
    thread_local std::size_t taken = 0;
    taken += bytes;
    if (taken < kBreath) return;
    taken = 0;
    keeper->keep();
}

bool isOn()
{
    return gHeap != nullptr;
}

const char* problem() noexcept
{
    return gHasProblem ? gProblem.data() : nullptr;
}

void checkScratch()
{
    if (const char* const text = problem()) throw OutputError(text);
}

void* allocate(std::size_t bytes) noexcept
{
    PagedHeap* const heap = gHeap.load(std::memory_order_acquire);
    if (__builtin_expect(!heap, 1) || bytes < PagedHeap::kLeast) return nullptr;
    breathe(bytes);
    void* const memory = heap->allocate(bytes);
    if (!memory && heap->problem() != 0) noteProblem(heap->problem(), heap->runs() * PagedHeap::kRun);
    return memory;
}

bool release(void* memory) noexcept
{
    PagedHeap* const heap = gHeap.load(std::memory_order_acquire);
    if (__builtin_expect(!heap, 1) || !heap->owns(memory)) return false;
    breathe(heap->release(memory)); // lists are read while they are freed
    return true;
}

} // namespace vdblic::paging
