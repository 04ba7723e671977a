#include "cli/console.h"

#include <fmt/format.h>

#include <cstdio>
#include <unistd.h>

namespace vdblic::cli {
namespace {

using Seconds = std::chrono::duration<double>;
constexpr Seconds kLineInterval{10};

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
    const std::string count = total > 0 ? fmt::format("{}/{}", done, total) : fmt::format("{}", done);
    std::string rest;
    if (total > 0 && done > 0 && done < total) {
        rest = fmt::format(", {:.0f} s left", elapsed / double(done) * double(total - done));
    }
    if (mTerminal) {
        constexpr std::size_t kWidth = 30;
        const std::size_t filled = total > 0 ? kWidth * done / total : 0;
        fmt::print(stderr, "\r\033[K{} [{:#<{}}{:.<{}}] frame {}, {:.0f} s{}", mTool, "", filled, "", kWidth - filled,
                   count, elapsed, rest);
        std::fflush(stderr);
        mBarShown = true;
        if (total > 0 && done == total) clearBar();
    } else if (now - mLastLine >= kLineInterval || (total > 0 && done == total)) {
        fmt::print(stderr, "{}: frame {}, {:.1f} s{}\n", mTool, count, elapsed, rest);
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

void Console::error(std::string_view message)
{
    print("error: ", message);
}

void Console::finished(const std::filesystem::path& output)
{
    clearBar();
    const std::string line = output.string() + '\n';
    if (std::fwrite(line.data(), 1, line.size(), stdout) != line.size() || std::fflush(stdout) != 0) throw ClosedPipe{};
}

void Console::print(std::string_view kind, std::string_view message)
{
    clearBar();
    fmt::print(stderr, "{}: {}{}\n", mTool, kind, message);
}

void Console::clearBar()
{
    if (!mBarShown) return;
    fmt::print(stderr, "\r\033[K");
    std::fflush(stderr);
    mBarShown = false;
}

} // namespace vdblic::cli
