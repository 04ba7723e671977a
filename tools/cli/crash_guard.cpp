#include "cli/crash_guard.h"

#include "cli/exit_status.h"
#include "vdblic/core/hazard.h"
#include "vdblic/core/paging.h"
#include "vdblic/core/system_memory.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <new>
#include <sys/resource.h>
#include <unistd.h>

namespace vdblic::cli {
namespace {

// Limit on the processor time of parsing, after which it counts as endless: 5 s plus a share for large files. The
// slowest files, compressed by zip, are read at 50 MB/s.
constexpr std::uint64_t kSeconds = 5, kBytesPerSecond = 5'000'000;

std::array<char, 64> gTool{};

/// The file that this thread parses. Plain data, which a signal handler may read.
struct Parsing {
    volatile sig_atomic_t active = 0;
    bool timed = false;
    timer_t timer{};
    std::array<char, 4200> file{};
};
thread_local Parsing tParsing;

/// An allocation failed in this thread. The exception may leave a function that must not throw, which aborts.
thread_local volatile sig_atomic_t tMemoryRanOut = 0;

void onNoMemory()
{
    tMemoryRanOut = 1;
    throw std::bad_alloc();
}

/// Whether the process is close to its limit on data. C libraries crash where an allocation fails.
bool isMemoryUsedUp()
{
    rlimit limit{};
    constexpr std::uint64_t kNear = 16 << 20;
    return ::getrlimit(RLIMIT_DATA, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
           processMemory().data + kNear > limit.rlim_cur;
}

/// A message put together without allocation; what does not fit is cut off.
class Line {
  public:
    void add(const char* text)
    {
        const std::size_t length = std::min(std::strlen(text), mText.size() - mLength);
        std::memcpy(mText.data() + mLength, text, length);
        mLength += length;
    }
    void print() const { (void)!::write(STDERR_FILENO, mText.data(), mLength); }

  private:
    std::array<char, 4600> mText{};
    std::size_t mLength = 0;
};

/// Several threads may run out of memory together: the first one speaks and ends the process, the others wait for that.
std::atomic_flag gSpoken{};
static_assert(std::atomic<bool>::is_always_lock_free); // in a signal handler
thread_local volatile sig_atomic_t tSpeaks = 0;

void speakFirst()
{
    if (tSpeaks) ::_exit(static_cast<int>(ExitStatus::kBadInput)); // a crash in the handler itself
    while (gSpoken.test_and_set())
        ::pause();
    tSpeaks = 1;
}

extern "C" void onCrash(int signal)
{
    const bool memory = (signal == SIGABRT && tMemoryRanOut) || isMemoryUsedUp();
    if (!tParsing.active && !memory) {
        std::signal(signal, SIG_DFL);
        (void)std::raise(signal);
        return;
    }
    speakFirst();
    const char* const scratch = memory ? paging::problem() : nullptr;
    Line line;
    if (::isatty(STDERR_FILENO)) line.add("\r\033[K");
    line.add(gTool.data());
    line.add(": error: ");
    if (scratch) {
        line.add(scratch);
    } else if (tParsing.active) {
        line.add(tParsing.file.data());
        line.add(": cannot be read as a .vdb file: it is damaged");
        line.add(memory              ? ", or takes more memory than may be used: raise --max-memory"
                 : signal == SIGXCPU ? "; reading it does not come to an end"
                                     : "; OpenVDB crashed on it");
    } else {
        line.add("this takes more memory than may be used: cut the domain, use fewer threads, or raise --max-memory");
    }
    line.add("\n");
    line.print();
    ::_exit(static_cast<int>(scratch ? ExitStatus::kCannotWrite : ExitStatus::kBadInput));
}

void startTimer(std::uint64_t seconds) noexcept
{
    sigevent event{};
    event.sigev_notify = SIGEV_THREAD_ID;
    event.sigev_signo = SIGXCPU;
#ifdef sigev_notify_thread_id
    event.sigev_notify_thread_id = ::gettid();
#else
    event._sigev_un._tid = ::gettid(); // glibc before 2.38 has no public name for it
#endif
    itimerspec limit{};
    limit.it_value.tv_sec = time_t(seconds);
    tParsing.timed = ::timer_create(CLOCK_THREAD_CPUTIME_ID, &event, &tParsing.timer) == 0;
    if (tParsing.timed) ::timer_settime(tParsing.timer, 0, &limit, nullptr);
}

void enter(const char* file, std::uint64_t size) noexcept
{
    std::snprintf(tParsing.file.data(), tParsing.file.size(), "%s", file);
    tParsing.active = 1;
    startTimer(kSeconds + size / kBytesPerSecond);
}

void leave() noexcept
{
    if (tParsing.timed) ::timer_delete(tParsing.timer);
    tParsing.timed = false;
    tParsing.active = 0;
}

} // namespace

void guardAgainstCrashes(const std::string& tool)
{
    std::snprintf(gTool.data(), gTool.size(), "%s", tool.c_str());
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU}) {
        struct sigaction action {};
        action.sa_handler = onCrash;
        action.sa_flags = SA_NODEFER;
        ::sigaction(signal, &action, nullptr);
    }
    std::set_new_handler(onNoMemory);
    setHazardHooks({enter, leave});
}

} // namespace vdblic::cli
