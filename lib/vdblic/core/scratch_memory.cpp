#include "vdblic/core/scratch_memory.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/paged_heap.h"
#include "vdblic/core/scratch_file.h"
#include "vdblic/core/system_memory.h"

#include <fmt/format.h>

#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <pthread.h>
#include <system_error>
#include <thread>
#include <utility>

namespace vdblic {
namespace {

constexpr std::uint64_t kLate = std::uint64_t(24) << 20;         // growth possible before eviction begins
constexpr std::uint64_t kLeastScratch = std::uint64_t(16) << 20; // stay resident, however much else the process holds
constexpr double kNear = 0.8;                                    // estimates are a quarter wrong at most
constexpr std::uint64_t kLarge = std::uint64_t(512) << 20;       // a limit that large pages do not soon exceed
constexpr double kSpread = 1.25; // bytes of the file for each byte of objects: runs have gaps

} // namespace

/// Keeps the process's resident memory below a limit.
///
/// Evicts runs cyclically, in file order. Runs in use return from the page cache at once; the others are the least
/// recently used, because work sweeps the whole memory.
class ResidentKeeper {
  public:
    ResidentKeeper(const PagedHeap& heap, std::uint64_t limit); ///< @param heap must outlive this

    void keep();
    /// Start a permanent thread that evicts, since threads also allocate without breathing. It takes no signals; its
    /// stack counts little towards the limit on data. @return 0, or the errno of the failure
    [[nodiscard]] int startThread();

  private:
    [[nodiscard]] bool isTooMuch(const ProcessMemory& now, std::uint64_t step) const;

    const PagedHeap& mHeap;
    std::uint64_t mMost, mStep, mCode;
    std::mutex mMutex;
    std::size_t mNext = 0; // run to evict next
};

ResidentKeeper::ResidentKeeper(const PagedHeap& heap, std::uint64_t limit)
    : mHeap(heap), mMost(limit - limit / 8 - kLate), mStep(limit / 16), mCode(processMemory().files)
{
}

void ResidentKeeper::keep()
{
    if (!isTooMuch(processMemory(), 0)) return;
    const std::lock_guard lock(mMutex);
    constexpr std::size_t kTogether = 4; // runs
    for (std::size_t passed = 0; isTooMuch(processMemory(), mStep) && passed < mHeap.runs(); passed += kTogether) {
        mHeap.letGo(mNext, kTogether);
        mNext = mNext + kTogether < mHeap.runs() ? mNext + kTogether : 0;
    }
}

bool ResidentKeeper::isTooMuch(const ProcessMemory& now, std::uint64_t step) const
{
    return now.resident + step > mMost && now.files > mCode + kLeastScratch;
}

int ResidentKeeper::startThread()
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
        for (;;) {
            static_cast<ResidentKeeper*>(of)->keep();
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    };
    const int reason = ::pthread_create(&thread, &attributes, watch, this);
    ::pthread_attr_destroy(&attributes);
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
    return reason;
}

std::atomic<ScratchMemory*> ScratchMemory::sBegun = nullptr;

ScratchMemory::ScratchMemory(std::filesystem::path folder, std::uint64_t limit, double inFiles)
    : mFolder(std::move(folder)), mLimit(limit), mInFiles(inFiles)
{
    std::snprintf(mFailure.data(), mFailure.size(),
                  "%s: the scratch file cannot be written or read back: the disk is full, or fails; make room, or give "
                  "another folder with --scratch",
                  mFolder.c_str());
}

/// Free bytes on the disk; 0 if unknown.
std::uintmax_t ScratchMemory::freeBytes() const
{
    std::error_code error;
    const std::filesystem::space_info space = std::filesystem::space(mFolder, error);
    return error ? 0 : space.available;
}

/// Requires the lock.
void ScratchMemory::begin()
{
    if (isBegun()) return;
    auto* const heap = new PagedHeap(*new ScratchFile(mFolder, mLimit >= kLarge)); // never freed
    auto* const keeper = new ResidentKeeper(*heap, mLimit);
    if (const int reason = keeper->startThread(); reason != 0)
        throw std::system_error(reason, std::generic_category(), "the thread that keeps to the memory");
    mHeap = heap;
    mKeeper = keeper;
    sBegun.store(this, std::memory_order_release);
}

bool ScratchMemory::makeRoom(double bytes)
{
    const std::lock_guard lock(mMutex);
    if (!isBegun() && bytes <= kNear * double(mLimit)) return false;
    begin();
    const double size = kSpread * bytes;
    if (const int reason = mHeap->reserve(std::size_t(size)); reason != 0) {
        throw OutputError(fmt::format("{}: there is no room for a scratch file of {}, and {} are free: {}; make room, "
                                      "or give another folder with `scratch`",
                                      mFolder.string(), memoryText(size), memoryText(double(freeBytes())),
                                      std::generic_category().message(reason)));
    }
    return true;
}

void ScratchMemory::expectFiles(double bytes)
{
    const std::lock_guard lock(mMutex);
    constexpr double kTool = 40e6; // bytes of a tool without its data
    if (kTool + mInFiles * bytes > kNear * double(mLimit)) begin();
}

bool ScratchMemory::mayHold(double bytes) const
{
    return bytes <= double(mLimit) + double(freeBytes());
}

void ScratchMemory::breathe(std::size_t bytes)
{
    if (!isBegun()) return;
    constexpr std::size_t kBreath = std::size_t(1) << 19;
    thread_local std::size_t taken = 0;
    taken += bytes;
    if (taken < kBreath) return;
    taken = 0;
    mKeeper->keep();
}

void ScratchMemory::noteProblem() noexcept
{
    const std::lock_guard lock(mProblemMutex);
    if (mHasProblem) return;
    std::snprintf(
        mProblem.data(), mProblem.size(),
        "%s: the scratch file cannot grow beyond %zu MiB: %s; make room, or give another folder with --scratch",
        mFolder.c_str(), mHeap->runs() * PagedHeap::kRun >> 20, ::strerrordesc_np(mHeap->problem()));
    mHasProblem = true;
}

const char* ScratchMemory::problem() const noexcept
{
    return mHasProblem ? mProblem.data() : nullptr;
}

const char* ScratchMemory::failureAt(const void* address) const noexcept
{
    return isBegun() && mHeap->owns(address) ? mFailure.data() : nullptr;
}

void* ScratchMemory::take(std::size_t bytes) noexcept
{
    if (bytes < PagedHeap::kLeast) return nullptr;
    breathe(bytes);
    void* const memory = mHeap->allocate(bytes);
    if (!memory && mHeap->problem() != 0) noteProblem();
    return memory;
}

bool ScratchMemory::giveBack(void* memory) noexcept
{
    if (!mHeap->owns(memory)) return false;
    breathe(mHeap->release(memory)); // lists are read while they are freed
    return true;
}

} // namespace vdblic
