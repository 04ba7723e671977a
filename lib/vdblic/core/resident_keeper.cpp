#include "vdblic/core/resident_keeper.h"

#include <chrono>
#include <csignal>
#include <pthread.h>
#include <thread>

namespace vdblic {
namespace {

constexpr std::uint64_t kLate = std::uint64_t(24) << 20;         // growth possible before eviction begins
constexpr std::uint64_t kLeastScratch = std::uint64_t(16) << 20; // stay resident, however much else the process holds

} // namespace

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

} // namespace vdblic
