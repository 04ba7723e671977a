#include "vdblic/core/threads.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <csignal>
#include <mutex>
#include <pthread.h>
#include <sys/mman.h>
#include <vector>

namespace vdblic {

std::size_t threadCount()
{
    return std::min(std::size_t(tbb::this_task_arena::max_concurrency()),
                    tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

std::size_t startableThreads(std::size_t most)
{
    constexpr std::size_t kStack = std::size_t(8) << 20;
    struct Started {
        pthread_t thread;
        void* stack; // allocated here, because the C library caches its own stacks
    };
    std::vector<Started> started;
    started.reserve(most);
    std::mutex wait;
    std::unique_lock all(wait); // all threads exist at once
    const auto run = [](void* of) -> void* {
        const std::lock_guard lock(*static_cast<std::mutex*>(of));
        return nullptr;
    };
    sigset_t signals, before;
    ::sigfillset(&signals);
    ::pthread_sigmask(SIG_SETMASK, &signals, &before); // the threads block all signals
    for (std::size_t i = 0; i < most; ++i) {
        void* const stack = ::mmap(nullptr, kStack, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (stack == MAP_FAILED) break;
        pthread_attr_t attributes;
        ::pthread_attr_init(&attributes);
        ::pthread_attr_setstack(&attributes, stack, kStack);
        pthread_t thread{};
        const bool isStarted = ::pthread_create(&thread, &attributes, run, &wait) == 0;
        ::pthread_attr_destroy(&attributes);
        if (!isStarted) {
            ::munmap(stack, kStack);
            break;
        }
        started.push_back({thread, stack});
    }
    all.unlock();
    for (const Started& one : started) {
        ::pthread_join(one.thread, nullptr);
        ::munmap(one.stack, kStack);
    }
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
    return started.size();
}

} // namespace vdblic
