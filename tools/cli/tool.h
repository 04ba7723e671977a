#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/io/sequence.h"

#include <CLI/CLI.hpp>

#include <functional>
#include <string>

namespace vdblic::cli {

/// What a tool's process returns; the same for every tool (docs/formats.md).
enum class ExitStatus { kDone = 0, kDiffers = 1, kUsage = 2, kBadInput = 3, kCannotWrite = 4, kBug = 5 };

/// A command-line tool: options common to all (`--threads`, `-q`, `-v`, `--version`), its own added by the caller,
/// errors of the library turned into one message and the documented exit status.
class Tool {
  public:
    Tool(std::string name, const std::string& description);

    /// Add an option whose default is the target's value and appears in the help.
    template<typename T>
    CLI::Option* option(const std::string& name, T& target, const std::string& help)
    {
        return mApp.add_option(name, target, help)->capture_default_str();
    }
    /// The positional input sequence and its `--frames`.
    void inputSequence(const std::string& name, SequenceParams& target, const std::string& help);
    /// The required `-o,--output`.
    void output(std::string& target, const std::string& help);

    /// `--skip-existing`, for stages whose frames do not depend on each other.
    void skipExisting(bool& target);

    CLI::App& app() { return mApp; }

    /// Parse, run the job, report what it throws.
    /// @return the process's exit status
    int run(int argc, char** argv, const std::function<ExitStatus(Reporter&)>& job);
    int run(int argc, char** argv, const std::function<void(Reporter&)>& job);

  private:
    CLI::App mApp;
    int mThreads = 0;
    bool mQuiet = false, mVerbose = false;
};

} // namespace vdblic::cli
