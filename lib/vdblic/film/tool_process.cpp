#include "vdblic/film/tool_process.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <sys/resource.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace vdblic {
namespace {

namespace fs = std::filesystem;

/// A running tool. Its destructor ends it.
class ToolProcess {
  public:
    ToolProcess(const fs::path& program, const std::vector<std::string>& arguments)
    {
        std::vector<std::string> words = {program.string()};
        words.insert(words.end(), arguments.begin(), arguments.end());
        std::vector<char*> pointers;
        pointers.reserve(words.size() + 1);
        for (std::string& word : words)
            pointers.push_back(word.data());
        pointers.push_back(nullptr);
        std::array<int, 2> messages{};
        if (::pipe2(messages.data(), O_CLOEXEC) != 0) fail(program, errno);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
        posix_spawn_file_actions_adddup2(&actions, messages[1], STDERR_FILENO);
        // In a group of its own it does not get the terminal's signals: this process decides when it ends.
        posix_spawnattr_t attributes;
        posix_spawnattr_init(&attributes);
        posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
        const int error = ::posix_spawn(&mProcess, words[0].c_str(), &actions, &attributes, pointers.data(), environ);
        posix_spawnattr_destroy(&attributes);
        posix_spawn_file_actions_destroy(&actions);
        ::close(messages[1]);
        mMessages = messages[0];
        if (error != 0) {
            ::close(mMessages);
            fail(program, error);
        }
        rlimit data{}; // lifts the tool's own limit, as for ffmpeg
        ::getrlimit(RLIMIT_DATA, &data);
        data.rlim_cur = data.rlim_max;
        ::prlimit(mProcess, RLIMIT_DATA, &data, nullptr);
    }
    ~ToolProcess()
    {
        if (mProcess > 0) ::kill(mProcess, SIGKILL);
        (void)wait();
        ::close(mMessages);
    }
    ToolProcess(const ToolProcess&) = delete;
    ToolProcess& operator=(const ToolProcess&) = delete;

    /// Pass lines of its messages on until it has closed them. @param visit called with each. @throws Stopped
    template<typename Visit>
    void read(const Reporter& reporter, const Visit& visit)
    {
        constexpr int kPatience = 100; // milliseconds between looks for a stop
        std::string text;
        for (bool isOpen = true; isOpen;) {
            if (reporter.stopRequested()) {
                ::kill(mProcess, SIGTERM);
                (void)wait(); // for what it cleans up
                throw Stopped{};
            }
            pollfd ready{mMessages, POLLIN, 0};
            if (::poll(&ready, 1, kPatience) <= 0) continue;
            std::array<char, 4096> part{};
            const ssize_t count = ::read(mMessages, part.data(), part.size());
            if (count < 0 && errno == EINTR) continue;
            isOpen = count > 0;
            text.append(part.data(), std::size_t(std::max<ssize_t>(count, 0)));
            if (!isOpen && !text.empty() && text.back() != '\n') text += '\n';
            std::size_t begin = 0;
            for (std::size_t end = 0; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1)
                visit(std::string_view(text).substr(begin, end - begin));
            text.erase(0, begin);
        }
    }

    /// Wait for its end. @return as of waitpid(), 0 if it has been waited for
    int wait()
    {
        int status = 0;
        while (mProcess > 0 && ::waitpid(mProcess, &status, 0) < 0 && errno == EINTR) {
        }
        mProcess = -1;
        return status;
    }

  private:
    [[noreturn]] static void fail(const fs::path& program, int error)
    {
        throw ParameterError(fmt::format("{}: cannot be started: {}; check the installation", program.string(),
                                         std::generic_category().message(error)));
    }

    pid_t mProcess = -1;
    int mMessages = -1; // from its standard error
};

/// Remove a beginning from a text. @return whether it was there
bool take(std::string_view& text, std::string_view beginning)
{
    if (!text.starts_with(beginning)) return false;
    text.remove_prefix(beginning.size());
    return true;
}

} // namespace

fs::path findTool(const std::string& name)
{
    std::error_code ignored;
    std::vector<fs::path> folders = {fs::read_symlink("/proc/self/exe", ignored).parent_path()};
    const char* const path = std::getenv("PATH");
    std::istringstream rest(path ? path : "");
    for (std::string folder; std::getline(rest, folder, ':');)
        folders.emplace_back(folder);
    for (const fs::path& folder : folders) {
        fs::path program = folder / name;
        if (!folder.empty() && fs::is_regular_file(program, ignored) && ::access(program.c_str(), X_OK) == 0)
            return program;
    }
    throw ParameterError(
        fmt::format("{} is missing, beside this program and on PATH; Debian's package vdblic has it, and "
                    "a build that finds Python's headers, NumPy and pybind11",
                    name));
}

void runTool(const std::string& name, const std::vector<std::string>& arguments, Reporter& reporter)
{
    ToolProcess process(findTool(name), arguments);
    std::string error;
    process.read(reporter, [&](std::string_view line) {
        (void)take(line, name + ": ");
        if (take(line, "error: ")) {
            error = line;
        } else if (take(line, "warning: ")) {
            reporter.warn(line);
        } else if (line.starts_with("frame ")) { // its progress
            reporter.detail(line);
        } else {
            reporter.say(line);
        }
    });
    const int status = process.wait();
    if (status == 0) return;
    if (error.empty() && WIFSIGNALED(status))
        error = fmt::format("was ended by signal {}; the machine may have too little memory", WTERMSIG(status));
    if (error.empty()) error = fmt::format("failed with status {}", WEXITSTATUS(status));
    error = fmt::format("{}: {}", name, error);
    constexpr int kUsage = 2, kInput = 3, kOutput = 4; // docs/formats.md
    switch (WIFSIGNALED(status) ? kInput : WEXITSTATUS(status)) {
    case kUsage:
        throw ParameterError(error);
    case kInput:
        throw InputError(error);
    case kOutput:
        throw OutputError(error);
    default:
        throw std::runtime_error(error);
    }
}

} // namespace vdblic
