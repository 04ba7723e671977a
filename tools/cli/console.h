#pragma once

#include "vdblic/core/parameters.h"
#include "vdblic/core/reporter.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace vdblic::cli {

/// Exit status of every tool (docs/formats.md). After a signal it is 128 plus the signal's number.
enum class ExitStatus { kDone = 0, kDiffers = 1, kUsage = 2, kBadInput = 3, kCannotWrite = 4, kBug = 5 };

/// The reader of standard output has closed it.
struct ClosedPipe {};

/// Print a text on standard error. Failing to print a message does not stop the work.
void printMessage(const std::string& text);

/// Reports to a terminal or a log: messages and progress on standard error, finished paths on standard output. Messages
/// name options where the library names parameters (option_names.h).
///
/// Progress is a bar that overwrites itself on a terminal, and otherwise a line for each frame. Stages of a pipeline
/// that share a terminal print a line every ten seconds at most.
class Console : public Reporter {
  public:
    enum class Level { kSilent, kQuiet, kNormal, kVerbose }; ///< kSilent: no output

    /// @param parameters of the tool; must outlive this
    Console(std::string tool, Level level, const Parameters& parameters);
    ~Console() override;
    void setLevel(Level level) { mLevel = level; }

    void progress(std::size_t done, std::size_t total) override;
    void detail(std::string_view message) override;
    void say(std::string_view message) override;
    void warn(std::string_view message) override;
    /// @throws ClosedPipe if the reader has closed standard output, OutputError if it cannot be written otherwise
    void finished(const std::filesystem::path& output) override;
    [[nodiscard]] bool stopRequested() const override;
    void error(std::string_view message);

  private:
    void print(std::string_view kind, std::string_view message);
    void clearBar();

    std::string mTool;
    const Parameters& mParameters;
    Level mLevel;
    bool mShared; // the terminal, with other stages of a pipeline
    bool mTerminal, mBarShown = false;
    std::optional<std::size_t> mBefore; // number of frames done when the run began
    std::optional<std::int64_t> mFrame; // number of the last finished output
    std::chrono::steady_clock::time_point mStart, mLastFrame;
};

/// Print one message for the exception that a catch clause handles. Stopped and ClosedPipe, which end the run by a
/// signal, are thrown on.
/// @return the exit status that the error has
ExitStatus tellFailure(Console& console);

/// Occupy the descriptors of standard streams that the caller has closed (`>&-`), so that no file reuses one of them
/// and receives printed text. Reading or writing such a stream fails. Call it before any file is opened.
void holdStandardStreams();
} // namespace vdblic::cli
