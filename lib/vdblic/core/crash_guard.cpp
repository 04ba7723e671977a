#include "vdblic/core/crash_guard.h"

#include "vdblic/core/crash_litter.h"
#include "vdblic/core/hazard.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/paging.h"
#include "vdblic/core/system_memory.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <exception>
#include <new>
#include <optional>
#include <stdexcept>
#include <sys/resource.h>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace vdblic {
namespace {

// Limit on the processor time of parsing, beyond which it counts as endless: 5 s, and 1 s for each 5 MB. The slowest
// files (zip) are read at 50 MB/s.
constexpr std::uint64_t kSeconds = 5, kBytesPerSecond = 5'000'000;

std::array<char, 64> gProgram{};
CrashStatuses gStatuses;

/// The file that this thread parses. Plain data, which a signal handler may read.
struct Parsing {
    volatile sig_atomic_t active = 0;
    bool timed = false;
    timer_t timer{};
    const char* library = nullptr;
    std::array<char, 4200> file{};
};
thread_local Parsing tParsing;

/// Bytes of the signal handler's own stack: a parser's recursion may have exhausted the thread's.
constexpr std::size_t kHandlerStack = std::size_t(1) << 16;
alignas(16) thread_local std::array<char, kHandlerStack> tHandlerStack;

/// Whether an allocation failed in this thread. Its exception aborts the process if it leaves a noexcept function.
thread_local volatile sig_atomic_t tMemoryRanOut = 0;

void onNoMemory()
{
    tMemoryRanOut = 1;
    throw std::bad_alloc();
}

/// Whether this thread failed to start another one: libraries abort then.
thread_local volatile sig_atomic_t tThreadsRanOut = 0;
std::terminate_handler gTerminate = nullptr; // the handler installed before ours

/// Record the exception that is about to abort the process because it left a noexcept function.
[[noreturn]] void onTerminate()
{
    try {
        if (const std::exception_ptr error = std::current_exception()) std::rethrow_exception(error);
    } catch (const std::bad_alloc&) {
        tMemoryRanOut = 1;
    } catch (const std::system_error& error) {
        if (error.code() == std::errc::resource_unavailable_try_again) tThreadsRanOut = 1;
    } catch (const std::runtime_error& error) { // TBB's has no code
        if (std::strstr(error.what(), "pthread_create")) tThreadsRanOut = 1;
    } catch (...) { // NOLINT(bugprone-empty-catch): a bug, which the previous handler reports
    }
    if (!tMemoryRanOut && !tThreadsRanOut) gTerminate();
    std::abort();
}

/// Whether the process is close to its limit on data or addresses. C libraries crash on a failed allocation.
bool isMemoryUsedUp()
{
    const auto isNear = [](int resource, std::uint64_t taken) {
        constexpr std::uint64_t kNear = 16 << 20;
        rlimit limit{};
        return ::getrlimit(resource, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && taken + kNear > limit.rlim_cur;
    };
    const ProcessMemory now = processMemory();
    return isNear(RLIMIT_DATA, now.data) || isNear(RLIMIT_AS, now.addresses);
}

/// Builds a message without allocating; truncates it to the buffer.
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

/// Set by the first thread that crashes: it prints the message and ends the process, the others wait.
std::atomic_flag gSpoken{};
static_assert(std::atomic<bool>::is_always_lock_free); // accessed in a signal handler
thread_local volatile sig_atomic_t tSpeaks = 0;

void speakFirst()
{
    if (tSpeaks) ::_exit(gStatuses.badInput); // a crash in the handler itself
    while (gSpoken.test_and_set())
        ::pause();
    tSpeaks = 1;
}

/// The message and exit status of a crash.
struct Cause {
    std::array<const char*, 5> text{}; ///< parts of the message
    int status = gStatuses.badInput;
};

constexpr const char* kDamaged = ": cannot be read: it is damaged";

/// @return nothing unless a file was being parsed, memory or threads ran out, or the scratch file failed
std::optional<Cause> causeOf(int signal, const siginfo_t& info)
{
    // A bus error in the scratch file is a disk failure, not a lack of memory.
    const char* const disk = signal == SIGBUS ? paging::failureAt(info.si_addr) : nullptr;
    if (disk) return Cause{{disk}, gStatuses.cannotWrite};
    const bool memory = (signal == SIGABRT && tMemoryRanOut) || isMemoryUsedUp();
    if (const char* const scratch = memory ? paging::problem() : nullptr)
        return Cause{{scratch}, gStatuses.cannotWrite};
    const char* const raise = hasMemoryOption() ? ", or raise --max-memory" : "";
    if (tParsing.active) {
        if (memory) return Cause{{tParsing.file.data(), kDamaged, ", or takes more memory than may be used", raise}};
        if (signal == SIGXCPU) return Cause{{tParsing.file.data(), kDamaged, "; reading it does not come to an end"}};
        return Cause{{tParsing.file.data(), kDamaged, "; ", tParsing.library, " crashed on it"}};
    }
    if (signal == SIGABRT && tThreadsRanOut) {
        return Cause{
            {"no further thread can be started: use fewer threads, or allow the user more processes (ulimit -u)",
             raise}};
    }
    if (memory) return Cause{{"this takes more memory than may be used: cut the domain, or use fewer threads", raise}};
    return std::nullopt;
}

extern "C" void onCrash(int signal, siginfo_t* info, void* /*context*/)
{
    const std::optional<Cause> cause = causeOf(signal, *info);
    if (!cause) {
        std::signal(signal, SIG_DFL);
        (void)std::raise(signal);
        return;
    }
    speakFirst();
    Line line;
    if (::isatty(STDERR_FILENO)) line.add("\r\033[K");
    line.add(gProgram.data());
    line.add(": error: ");
    for (const char* const part : cause->text) {
        if (part) line.add(part);
    }
    line.add("\n");
    line.print();
    removeCrashLitter();
    ::_exit(cause->status);
}

/// Called once per thread. Sanitizers give their threads a handler stack themselves.
void takeHandlerStack() noexcept
{
    thread_local bool isTaken = false;
    if (std::exchange(isTaken, true)) return;
    stack_t stack{};
    if (::sigaltstack(nullptr, &stack) != 0 || (stack.ss_flags & SS_DISABLE) == 0) return;
    stack = {.ss_sp = tHandlerStack.data(), .ss_flags = 0, .ss_size = tHandlerStack.size()};
    ::sigaltstack(&stack, nullptr);
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

void enter(const char* file, std::uint64_t size, const char* library) noexcept
{
    takeHandlerStack();
    tParsing.library = library;
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

void guardAgainstCrashes(const std::string& program, const CrashStatuses& statuses)
{
    gStatuses = statuses;
    std::snprintf(gProgram.data(), gProgram.size(), "%s", program.c_str());
    // A library loaded late (Python's module) allocates its thread-local variables at first use, by malloc(). The
    // handler must not be that first use: after a crash in malloc() it would deadlock.
    tParsing.active = 0;
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU}) {
        struct sigaction action {};
        action.sa_sigaction = onCrash;
        action.sa_flags = SA_NODEFER | SA_ONSTACK | SA_SIGINFO;
        ::sigaction(signal, &action, nullptr);
    }
    std::set_new_handler(onNoMemory);
    if (!gTerminate) gTerminate = std::set_terminate(onTerminate);
    setHazardHooks({enter, leave});
}

} // namespace vdblic
