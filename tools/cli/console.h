#pragma once

#include "vdblic/core/reporter.h"

#include <chrono>
#include <optional>
#include <string>

namespace vdblic::cli {

/// Whoever read our standard output has gone; there is nobody left to work for.
struct ClosedPipe {};

/// Reports to a terminal or a log: messages and progress on standard error, finished paths on standard output. Messages
/// name options where the library names parameters (option_names.h).
///
/// Progress is a bar that overwrites itself on a terminal, and otherwise a line every ten seconds at most.
class Console : public Reporter {
  public:
    enum class Level { kQuiet, kNormal, kVerbose };

    Console(std::string tool, Level level);
    ~Console() override;

    void progress(std::size_t done, std::size_t total) override;
    void detail(std::string_view message) override;
    void say(std::string_view message) override;
    void warn(std::string_view message) override;
    /// @throws ClosedPipe if nobody reads standard output any more, OutputError if it cannot be written otherwise
    void finished(const std::filesystem::path& output) override;
    [[nodiscard]] bool stopRequested() const override;
    void error(std::string_view message);

  private:
    void print(std::string_view kind, std::string_view message);
    void clearBar();

    std::string mTool;
    Level mLevel;
    bool mTerminal, mBarShown = false;
    std::optional<std::size_t> mBefore; // frames that were done when the run began
    std::chrono::steady_clock::time_point mStart, mLastLine;
};

} // namespace vdblic::cli
