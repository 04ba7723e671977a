#include "vdblic/core/crash_guard.h"

#include "temporary_folder.h"
#include "vdblic/core/hazard.h"
#include "vdblic/core/scratch_memory.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>
#include <optional>
#include <string>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>

namespace vdblic {
namespace {

/// How many threads of a process wait for a write, once two and the one that waits for them sleep or it has ended;
/// nothing before. 0 if the system does not tell.
std::optional<int> waitingToWrite(pid_t process)
{
    int threads = 0, writing = 0;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task")) {
        std::ifstream stat(entry.path() / "stat"), call(entry.path() / "syscall");
        const std::string told(std::istreambuf_iterator<char>(stat), {});
        const std::size_t name = told.rfind(')');
        const char state = name == std::string::npos ? '?' : told.at(name + 2);
        if (state == 'Z') return 0;
        if (state != 'S') return std::nullopt;
        ++threads;
        int number = -1;
        writing += call >> number && number == SYS_write ? 1 : 0;
    }
    return threads < 3 ? std::nullopt : std::optional(writing);
}

/// What a child process says before it ends by the status that is wanted.
/// @param isHeld whether it is heard only when its threads sleep, because the pipe holds a "." and has no room for more
template<typename Work>
std::string saidAt(int wanted, const Work& work, bool isHeld = false)
{
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), O_DIRECT) != 0) return "no pipe";
    if (isHeld && (::fcntl(pipe[1], F_SETPIPE_SZ, 4096) < 0 || ::write(pipe[1], ".", 1) != 1)) return "no page";
    const pid_t child = ::fork();
    if (child == 0) {
        ::dup2(pipe[1], STDERR_FILENO);
        guardAgainstCrashes("tool");
        work();
        ::_exit(0);
    }
    ::close(pipe[1]);
    if (isHeld) {
        std::optional<int> writing;
        while (!(writing = waitingToWrite(child)))
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        EXPECT_LE(*writing, 1); // the first to exit ends the others: their words would rarely be read
    }
    std::string said;
    std::array<char, 4096> part{};
    for (ssize_t length = 0; (length = ::read(pipe[0], part.data(), part.size())) > 0;)
        said.append(part.data(), std::size_t(length));
    ::close(pipe[0]);
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status)) << status;
    EXPECT_EQ(WEXITSTATUS(status), wanted);
    return said;
}

constexpr const char* kDamaged = "tool: error: v.vdb: cannot be read: it is damaged; OpenVDB crashed on it\n";

TEST(CrashGuard, SpeaksOnceWhenThreadsCrashTogether)
{
    const auto crash = [] {
        const Hazard parsing("v.vdb", 1);
        (void)std::raise(SIGSEGV);
    };
    const auto crashTogether = [&] {
        std::thread first(crash), second(crash);
        first.join();
        second.join();
    };
    EXPECT_EQ(saidAt(3, crashTogether, true), std::string(".") + kDamaged);
}

/// A recursion without end. @return never
int deeper(volatile int* before) // NOLINT(misc-no-recursion)
{
    volatile int here = *before + 1;
    return here == 0 ? here : deeper(&here) + here;
}

TEST(CrashGuard, TellsOfAStackThatOverflowsInAParser)
{
    const auto parse = [] {
        const Hazard parsing("v.vdb", 1);
        volatile int none = 1;
        (void)deeper(&none);
    };
    EXPECT_EQ(saidAt(3, parse), kDamaged);
    EXPECT_EQ(saidAt(3, [&] { std::thread(parse).join(); }), kDamaged);
}

TEST(CrashGuard, TellsWhatAFunctionThatMustNotThrowThrew)
{
    const auto terminate = [](const auto& error) {
        return [thrown = std::make_exception_ptr(error)]() noexcept { std::rethrow_exception(thrown); };
    };
    const std::string threads =
        saidAt(3, terminate(std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again))));
    EXPECT_TRUE(threads.starts_with("tool: error: no further thread can be started")) << threads;
    EXPECT_EQ(saidAt(3, terminate(std::bad_alloc())),
              "tool: error: this takes more memory than may be used: cut the domain, or use fewer threads\n");
}

/// The descriptor of the file without a name in a folder.
int scratchIn(const std::filesystem::path& folder)
{
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
        std::error_code gone;
        const std::string file = std::filesystem::read_symlink(entry.path(), gone).string();
        if (file.starts_with(folder.string() + "/")) return std::stoi(entry.path().filename().string());
    }
    return -1;
}

TEST(CrashGuard, TellsOfADiskThatFailsTheScratchFile)
{
    const TemporaryFolder folder;
    const auto lose = [&](bool parses) {
        constexpr std::uint64_t kLimit = std::uint64_t(1) << 30;
        auto& memory = *new ScratchMemory(folder.path(), kLimit, 1);
        paging::setMemory(memory);
        memory.expectFiles(double(kLimit));
        auto* const object = static_cast<volatile char*>(ScratchMemory::allocate(5000));
        *object = 1;
        std::optional<Hazard> parsing;
        if (parses) parsing.emplace("v.vdb", 1);                   // which is not to blame
        if (::ftruncate(scratchIn(folder.path()), 0) != 0) return; // as a disk that is full when a page is written
        *object = 2;
    };
    for (const bool parses : {false, true}) {
        EXPECT_EQ(
            saidAt(4, [&] { lose(parses); }),
            "tool: error: " + folder.path().string() +
                ": the scratch file cannot be written or read back: the disk is full, or fails; make room, or give "
                "another folder with --scratch\n");
    }
}

} // namespace
} // namespace vdblic
