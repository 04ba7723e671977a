#pragma once

#include "cli/console.h"
#include "cli/parameter_options.h"
#include "cli/ranks.h"
#include "vdblic/core/reporter.h"
#include "vdblic/io/sequence.h"

#include <CLI/CLI.hpp>

#include <functional>
#include <istream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdblic::cli {

/// A command-line tool: the options common to all (`--threads`, `--max-memory`, `-q`, `-v`, `--version`), and those
/// that the caller adds. Errors of the library, signals and crashes on damaged files become one message and the
/// documented exit status.
class Tool {
  public:
    Tool(std::string name, const std::string& description);

    /// Add options for the job's parameters. They are set before the job begins.
    void options(Parameters parameters, std::vector<OptionGroup> groups = {});
    /// The values that the command line gives, by key.
    [[nodiscard]] const std::map<std::string, Words>& given() const { return mOptions->given(); }

    /// Name the .vdb files that the job reads: `--verify` checks them, and a warning names files beside a pattern's
    /// that it does not match. @param inputs called once all options are parsed
    void reads(std::function<std::vector<SequenceParams>()> inputs);

    /// `--scratch`: allocations beyond the memory limit lie in a file on disk (core/paging.h).
    /// @param inFiles peak bytes of input resident at once, as a multiple of one input file
    /// @param output  returns a path of the job's output, in whose folder the file lies by default; called once all
    ///                options are parsed. Without it that is the folder for temporary files.
    void usesScratch(double inFiles, std::function<std::string()> output = {});

    /// Share the job with other processes, and the memory with the ones on this machine. After a signal all of them end
    /// by the status 128 and its number: a process that dies by a signal would end the others before they could. Only
    /// rank 0 prints, except on crashes.
    void share(const Ranks& ranks);

    /// A flag that prints a text instead of doing the job. @param text made when the flag is given
    CLI::Option* answers(const std::string& flag, const std::string& help, std::function<std::string()> text);

    CLI::App& app() { return mApp; }
    /// Standard input, for the job. It ends when a stop is requested.
    std::istream& standardInput() { return *mInput; }

    /// Parse the command line, run the job, and report its errors.
    /// @return the process's exit status
    int run(int argc, char** argv, const std::function<ExitStatus(Reporter&)>& job);
    int run(int argc, char** argv, const std::function<void(Reporter&)>& job);

  private:
    void limitMemory() const;
    [[nodiscard]] std::size_t threadsToUse(Reporter& reporter) const;
    void offerScratch() const;
    void verify(Reporter& reporter) const;
    [[nodiscard]] std::string expandedPattern() const;
    [[nodiscard]] std::optional<int> parse(int argc, char** argv);
    [[nodiscard]] std::optional<int> agreed(std::optional<int> told);
    void apply();
    void prepare(Console& console) const;
    [[nodiscard]] int endBy(int signal) const;
    [[nodiscard]] int tell(const CLI::Success& asked) const;

    CLI::App mApp;
    std::optional<ParameterOptions> mOptions;
    std::unique_ptr<std::istream> mInput;
    std::function<std::vector<SequenceParams>()> mInputs;
    int mThreads = 0, mProcesses = 1; // processes on this machine
    bool mIsShared = false, mPrints = true;
    Exchange* mExchange = nullptr; ///< with the ranks that share the job
    std::string mMaxMemory, mScratch, mAnswer, mRefusal;
    double mInFiles = 0; // 0: without a scratch file
    std::function<std::string()> mOutput;
    bool mQuiet = false, mVerbose = false, mVerify = false;
};

} // namespace vdblic::cli
