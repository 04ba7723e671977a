#include "view/worker.h"

#include <cstddef>
#include <utility>

namespace vdblic::view {

Worker::Worker() : mThread([this] { run(); }) {}

Worker::~Worker()
{
    {
        const std::lock_guard lock(mMutex);
        mStopped = true;
    }
    mChanged.notify_all();
    mThread.join();
}

void Worker::add(std::function<void()> work)
{
    constexpr std::size_t kMost = 8;
    const std::lock_guard lock(mMutex);
    mWork.push_back(std::move(work));
    if (mWork.size() > kMost) mWork.pop_front();
    mChanged.notify_all();
}

void Worker::run()
{
    std::unique_lock lock(mMutex);
    for (;;) {
        mChanged.wait(lock, [&] { return mStopped || !mWork.empty(); });
        if (mStopped) return;
        const std::function<void()> work = std::move(mWork.back());
        mWork.pop_back();
        lock.unlock();
        try {
            work();
        } catch (...) { // NOLINT(bugprone-empty-catch)
        }
        lock.lock();
    }
}

} // namespace vdblic::view
