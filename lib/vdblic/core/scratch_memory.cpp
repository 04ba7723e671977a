#include "vdblic/core/scratch_memory.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/resident_keeper.h"
#include "vdblic/core/scratch_file.h"

#include <fmt/format.h>

#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

namespace vdblic {
namespace {

constexpr double kNear = 0.8;                              // estimates are a quarter wrong at most
constexpr std::uint64_t kLarge = std::uint64_t(512) << 20; // a limit that large pages do not soon exceed
constexpr double kSpread = 1.25;                           // bytes of the file for each byte of objects: runs have gaps

} // namespace

std::atomic<ScratchMemory*> ScratchMemory::sBegun = nullptr;

ScratchMemory::ScratchMemory(std::filesystem::path folder, std::uint64_t limit, double inFiles)
    : mFolder(std::move(folder)), mLimit(limit), mInFiles(inFiles)
{
    std::snprintf(mFailure.data(), mFailure.size(),
                  "%s: the scratch file cannot be written or read back: the disk is full, or fails; make room, or give "
                  "another folder with --scratch",
                  mFolder.c_str());
}

/// On the disk; 0 if that is not known.
std::uintmax_t ScratchMemory::freeBytes() const
{
    std::error_code error;
    const std::filesystem::space_info space = std::filesystem::space(mFolder, error);
    return error ? 0 : space.available;
}

/// Under the lock.
void ScratchMemory::begin()
{
    if (isBegun()) return;
    auto* const heap = new PagedHeap(*new ScratchFile(mFolder, mLimit >= kLarge)); // for ever
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
