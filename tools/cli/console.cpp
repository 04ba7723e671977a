#include "cli/console.h"

#include "cli/option_names.h"
#include "cli/stop_signals.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/paging.h"
#include "vdblic/core/printable.h"
#include "vdblic/io/sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <fcntl.h>
#include <initializer_list>
#include <new>
#include <string>
#include <string_view>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace vdblic::cli {
namespace {

using Seconds = std::chrono::duration<double>;
constexpr Seconds kSharedInterval{10};

std::size_t terminalColumns()
{
    winsize size{};
    constexpr std::size_t kUsual = 80;
    return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsual;
}

bool isPipe(int descriptor)
{
    struct stat status {};
    return ::fstat(descriptor, &status) == 0 && S_ISFIFO(status.st_mode);
}

ExitStatus tellBug(Console& console, std::string_view what)
{
    console.error(fmt::format("internal error, please report it: {}", what));
    return ExitStatus::kBug;
}

ExitStatus tellLackOfMemory(Console& console)
{
    if (const char* const scratch = paging::problem()) {
        console.error(scratch);
        return ExitStatus::kCannotWrite;
    }
    console.error(fmt::format("this takes more than the {} of memory that may be used: cut the domain, use fewer "
                              "threads, or raise --max-memory",
                              memoryText(double(memoryLimit()))));
    return ExitStatus::kBadInput;
}

} // namespace

void printMessage(const std::string& text)
{
    (void)!std::fwrite(text.data(), 1, text.size(), stderr);
    std::fflush(stderr);
}

Console::Console(std::string tool, Level level, const Parameters& parameters)
    : mTool(std::move(tool)), mParameters(parameters), mLevel(level),
      mShared(::isatty(STDERR_FILENO) != 0 && (isPipe(STDIN_FILENO) || isPipe(STDOUT_FILENO))),
      mTerminal(::isatty(STDERR_FILENO) != 0 && !mShared), mStart(std::chrono::steady_clock::now()), mLastFrame(mStart)
{
}

Console::~Console()
{
    clearBar();
}

void Console::progress(std::size_t done, std::size_t total)
{
    if (mLevel <= Level::kQuiet) return;
    const auto now = std::chrono::steady_clock::now();
    const double elapsed = Seconds(now - mStart).count();
    if (!mBefore) mBefore = done > 0 ? done - 1 : 0;
    const std::string count = total > 0 ? fmt::format("{}/{}", done, total) : fmt::format("{}", done);
    std::string rest;
    if (total > 0 && done > *mBefore && done < total) {
        rest = fmt::format(", {:.0f} s left", elapsed / double(done - *mBefore) * double(total - done));
    }
    if (mTerminal) {
        const std::string text = fmt::format(" frame {}, {:.0f} s{}", count, elapsed, rest);
        const std::size_t around = mTool.size() + text.size() + 4, columns = terminalColumns();
        const std::size_t width = std::min<std::size_t>(columns - std::min(columns, around), 30);
        const std::size_t filled = total > 0 ? width * done / total : 0;
        const std::string bar =
            width > 0 ? fmt::format("{} [{:#<{}}{:.<{}}]", mTool, "", filled, "", width - filled) : "";
        printMessage(fmt::format("\r\033[K{:.{}}", bar + text, columns - 1));
        mBarShown = true;
        if (total > 0 && done == total) clearBar();
    } else if (done > *mBefore && (!mShared || now - mLastFrame >= kSharedInterval || done == total)) {
        const std::string frame = mFrame ? fmt::format("frame {}: ", *mFrame) : "";
        printMessage(
            fmt::format("{}: {}{:.1f} s, {} done{}\n", mTool, frame, Seconds(now - mLastFrame).count(), count, rest));
        mLastFrame = now;
        mFrame.reset();
    }
}

void Console::detail(std::string_view message)
{
    if (mLevel == Level::kVerbose) print("", message);
}

void Console::say(std::string_view message)
{
    if (mLevel > Level::kQuiet) print("", message);
}

void Console::warn(std::string_view message)
{
    print("warning: ", message);
}

bool Console::stopRequested() const
{
    return stopSignal() != 0;
}

void Console::error(std::string_view message)
{
    print("error: ", message);
}

void Console::finished(const std::filesystem::path& output)
{
    clearBar();
    mFrame = frameOfName(output);
    const std::string line = output.string() + '\n';
    if (std::fwrite(line.data(), 1, line.size(), stdout) == line.size() && std::fflush(stdout) == 0) return;
    if (errno == EPIPE) throw ClosedPipe{};
    if (errno == EINTR) throw Stopped{};
    throw OutputError(fmt::format("standard output: cannot be written: {}", std::generic_category().message(errno)));
}

void Console::print(std::string_view kind, std::string_view message)
{
    if (mLevel == Level::kSilent) return;
    clearBar();
    printMessage(fmt::format("{}: {}{}\n", mTool, kind, printable(withOptionNames(message, mParameters))));
}

void Console::clearBar()
{
    if (!mBarShown) return;
    printMessage("\r\033[K");
    mBarShown = false;
}

ExitStatus tellFailure(Console& console)
{
    try {
        throw;
    } catch (const Stopped&) {
        throw;
    } catch (const ClosedPipe&) {
        throw;
    } catch (const ParameterError& error) {
        console.error(error.what());
        return ExitStatus::kUsage;
    } catch (const InputError& error) {
        console.error(error.what());
        return ExitStatus::kBadInput;
    } catch (const OutputError& error) {
        console.error(error.what());
        return ExitStatus::kCannotWrite;
    } catch (const std::bad_alloc&) {
        return tellLackOfMemory(console);
    } catch (const std::system_error& error) {
        if (error.code() != std::errc::resource_unavailable_try_again) return tellBug(console, error.what());
        console.error("no further thread can be started: use fewer --threads, raise --max-memory, which includes 8 MiB "
                      "a thread, or allow the user more processes (ulimit -u)");
        return ExitStatus::kBadInput;
    } catch (const std::exception& error) {
        return tellBug(console, error.what());
    } catch (...) {
        return tellBug(console, "an exception that is no std::exception");
    }
}

void holdStandardStreams()
{
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        if (::fcntl(stream, F_GETFD) < 0) // the lowest free descriptor is this one
            (void)::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
    }
}

} // namespace vdblic::cli
