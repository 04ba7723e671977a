#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace vdblic::view {

/// One thread that does work which nobody waits for, the newest first. Of too much work the oldest is dropped, and what
/// throws is forgotten: whoever needs its result does the work again, and reports the error.
class Worker {
  public:
    Worker();
    ~Worker();
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

    void add(std::function<void()> work);

  private:
    void run();

    std::mutex mMutex;
    std::condition_variable mChanged;
    std::deque<std::function<void()>> mWork;
    bool mStopped = false;
    std::thread mThread;
};

} // namespace vdblic::view
