#include "cli/console.h"

#include "cli/option_names.h"
#include "cli/stop_signals.h"
#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <unistd.h>

namespace vdblic::cli {
namespace {

using Seconds = std::chrono::duration<double>;
constexpr Seconds kLineInterval{10};

/// Where nobody listens to messages, the work goes on.
void toStandardError(const std::string& text)
{
    (void)!std::fwrite(text.data(), 1, text.size(), stderr);
    std::fflush(stderr);
}

} // namespace

Console::Console(std::string tool, Level level)
    : mTool(std::move(tool)), mLevel(level), mTerminal(::isatty(STDERR_FILENO) != 0),
      mStart(std::chrono::steady_clock::now()), mLastLine(mStart)
{
}

Console::~Console()
{
    clearBar();
}

void Console::progress(std::size_t done, std::size_t total)
{
    if (mLevel == Level::kQuiet) return;
    const auto now = std::chrono::steady_clock::now();
    const double elapsed = Seconds(now - mStart).count();
    if (!mBefore) mBefore = done > 0 ? done - 1 : 0;
    const std::string count = total > 0 ? fmt::format("{}/{}", done, total) : fmt::format("{}", done);
    std::string rest;
    if (total > 0 && done > *mBefore && done < total) {
        rest = fmt::format(", {:.0f} s left", elapsed / double(done - *mBefore) * double(total - done));
    }
    if (mTerminal) {
        constexpr std::size_t kWidth = 30;
        const std::size_t filled = total > 0 ? kWidth * done / total : 0;
        toStandardError(fmt::format("\r\033[K{} [{:#<{}}{:.<{}}] frame {}, {:.0f} s{}", mTool, "", filled, "",
                                    kWidth - filled, count, elapsed, rest));
        mBarShown = true;
        if (total > 0 && done == total) clearBar();
    } else if (now - mLastLine >= kLineInterval || (total > 0 && done == total)) {
        toStandardError(fmt::format("{}: frame {}, {:.1f} s{}\n", mTool, count, elapsed, rest));
        mLastLine = now;
    }
}

void Console::detail(std::string_view message)
{
    if (mLevel == Level::kVerbose) print("", message);
}

void Console::say(std::string_view message)
{
    if (mLevel != Level::kQuiet) print("", message);
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
    const std::string line = output.string() + '\n';
    if (std::fwrite(line.data(), 1, line.size(), stdout) == line.size() && std::fflush(stdout) == 0) return;
    if (errno == EPIPE) throw ClosedPipe{};
    throw OutputError(fmt::format("standard output: cannot be written: {}", std::generic_category().message(errno)));
}

void Console::print(std::string_view kind, std::string_view message)
{
    clearBar();
    toStandardError(fmt::format("{}: {}{}\n", mTool, kind, withOptionNames(message, mTool)));
}

void Console::clearBar()
{
    if (!mBarShown) return;
    toStandardError("\r\033[K");
    mBarShown = false;
}

} // namespace vdblic::cli
