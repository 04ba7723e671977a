#include "cli/crash_guard.h"

#include "vdblic/core/hazard.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace vdblic::cli {
namespace {

/// Two threads that crash together in the middle of a file.
[[noreturn]] void crashTogether()
{
    guardAgainstCrashes("tool");
    const auto crash = [] {
        const Hazard parsing("v.vdb", 1);
        (void)std::raise(SIGSEGV);
    };
    std::thread first(crash), second(crash);
    first.join();
    second.join();
    ::_exit(0);
}

TEST(CrashGuard, SpeaksOnceWhenThreadsCrashTogether)
{
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe2(pipe.data(), O_DIRECT), 0);
    ::fcntl(pipe[1], F_SETPIPE_SZ, 4096);   // it holds one write; writers wait in turn for the next
    ASSERT_EQ(::write(pipe[1], ".", 1), 1); // until it is read all threads have come to their first word
    const pid_t child = ::fork();
    if (child == 0) {
        ::dup2(pipe[1], STDERR_FILENO);
        crashTogether();
    }
    ::close(pipe[1]);
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    std::string said;
    std::array<char, 4096> part{};
    for (ssize_t length = 0; (length = ::read(pipe[0], part.data(), part.size())) > 0;)
        said.append(part.data(), std::size_t(length));
    ::close(pipe[0]);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 3);
    EXPECT_EQ(said.substr(1),
              "tool: error: v.vdb: cannot be read as a .vdb file: it is damaged; OpenVDB crashed on it\n");
}

} // namespace
} // namespace vdblic::cli
