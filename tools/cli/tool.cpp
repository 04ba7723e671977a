#include "cli/tool.h"

#include "cli/console.h"
#include "cli/crash_guard.h"
#include "cli/mistyped_option.h"
#include "cli/stop_signals.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/paging.h"
#include "vdblic/core/system_memory.h"
#include "vdblic/core/threads.h"
#include "vdblic/core/version.h"
#include "vdblic/io/pattern_advice.h"
#include "vdblic/io/vdb_file.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <sys/resource.h>
#include <system_error>

namespace vdblic::cli {
namespace {

constexpr int kMaxThreads = 1024;
constexpr std::uint64_t kLeastMemory = std::uint64_t(128) << 20;

int status(ExitStatus value)
{
    return static_cast<int>(value);
}

/// The existing files of a sequence.
std::vector<std::filesystem::path> filesOf(const SequenceParams& input)
{
    if (input.pattern == "-") return {}; // checked as they arrive
    const FramePattern pattern(input.pattern);
    if (!pattern.hasField()) return {pattern.path(1)};
    std::vector<std::int64_t> frames = pattern.framesOnDisk();
    if (!input.frames.empty()) {
        const std::vector<std::int64_t> chosen = parseFrameList(input.frames);
        std::erase_if(frames,
                      [&](std::int64_t frame) { return !std::binary_search(chosen.begin(), chosen.end(), frame); });
    }
    std::vector<std::filesystem::path> files;
    files.reserve(frames.size());
    for (const std::int64_t frame : frames)
        files.push_back(pattern.path(frame));
    return files;
}

std::filesystem::path temporaryFolder()
{
    std::error_code none;
    return std::filesystem::temp_directory_path(none); // of TMPDIR, or /tmp
}

} // namespace

Tool::Tool(std::string name, const std::string& description)
    : mApp(description, std::move(name)), mInput(stoppableInput())
{
    mApp.set_version_flag("--version", std::string(kVersion));
    mApp.add_option("--threads", mThreads,
                    "Threads to compute with; every core by default. Results do not depend on it.")
        ->check(CLI::Range(1, kMaxThreads));
    mApp.add_option("--max-memory", mMaxMemory,
                    "Memory that may be taken, such as 800M or 16G; what the machine has by default.")
        ->type_name("SIZE");
    CLI::Option* quiet = mApp.add_flag("-q,--quiet", mQuiet, "Print errors and warnings only.");
    mApp.add_flag("-v,--verbose", mVerbose, "Print details.")->excludes(quiet);
    mApp.footer("Exit status: 0 done, 2 usage, 3 bad input data, 4 output could not be written, 5 a bug; after a\n"
                "signal 128 and its number.\n"
                "The path of each finished output is printed on standard output, messages on standard error.");
}

void Tool::options(Parameters parameters)
{
    mOptions.emplace(mApp, std::move(parameters));
    const auto list = [this] {
        fmt::print("{}", toJson(mOptions->parameters()));
        throw CLI::Success{}; // before the required options are missed
    };
    mApp.add_flag_callback("--parameters", list, "Print the options as JSON, for programs, and exit.")
        ->group(kExpertGroup);
}

void Tool::reads(std::function<std::vector<SequenceParams>()> inputs)
{
    mInputs = std::move(inputs);
    mApp.add_flag("--verify", mVerify,
                  "Check every input file before starting: its header and, where VDBLIC wrote it, its checksums.");
}

/// Memory is limited by the process's own limit on data: any allocation beyond it fails, in every library.
void Tool::limitMemory() const
{
    const std::uint64_t held = processMemory().data, least = std::max(kLeastMemory, held);
    const std::uint64_t limit =
        mMaxMemory.empty() ? memoryLimit() / std::uint64_t(mProcesses) : parseMemory(mMaxMemory);
    if (!mMaxMemory.empty() && limit < least) {
        throw ParameterError(fmt::format("--max-memory {} is too little; a tool needs {}", memoryText(double(limit)),
                                         memoryText(double(least))));
    }
    rlimit data{};
    ::getrlimit(RLIMIT_DATA, &data);
    if (limit <= held || limit >= data.rlim_cur) return; // sanitizers reserve more memory than exists
    data.rlim_cur = limit;
    ::setrlimit(RLIMIT_DATA, &data);
}

void Tool::usesScratch(double inFiles, std::function<std::string()> output)
{
    mInFiles = inFiles;
    mOutput = std::move(output);
    mApp.add_option("--scratch", mScratch,
                    fmt::format("Folder for a file that holds what is taken beyond --max-memory; {} by default.",
                                mOutput ? "that of the outputs" : "that for temporary files"))
        ->type_name("DIR");
}

void Tool::offerScratch() const
{
    std::error_code error;
    if (!mScratch.empty() && !std::filesystem::is_directory(mScratch, error))
        throw ParameterError(fmt::format("--scratch {}: no such folder", mScratch));
    if (mIsShared && !mScratch.empty())
        throw ParameterError("--scratch is of a single process: leave it out, and take more ranks");
    if (mInFiles == 0 || mIsShared) return; // ranks divide the work instead
    std::filesystem::path folder = mScratch;
    if (folder.empty()) folder = mOutput ? std::filesystem::path(mOutput()).parent_path() : temporaryFolder();
    paging::offer(folder.empty() ? "." : folder, memoryLimit(), mInFiles);
}

void Tool::verify(Reporter& reporter) const
{
    std::size_t files = 0, withChecksums = 0;
    std::vector<std::string> damaged;
    for (const SequenceParams& input : mInputs()) {
        for (const std::filesystem::path& path : filesOf(input)) {
            reporter.checkStop();
            ++files;
            try {
                withChecksums += verifyVdb(path) ? 1 : 0;
            } catch (const InputError& error) {
                damaged.emplace_back(error.what());
            }
        }
    }
    for (std::size_t i = 0; i + 1 < damaged.size(); ++i)
        reporter.warn(damaged[i]);
    if (!damaged.empty())
        throw InputError(fmt::format("{}; {} of {} files are damaged", damaged.back(), damaged.size(), files));
    reporter.say(fmt::format("{} files are in order, {} of them by their checksums", files, withChecksums));
}

/// What to say if the shell expanded a pattern into the names of files; empty if it did not.
std::string Tool::expandedPattern() const
{
    const std::vector<std::string> files = mApp.remaining();
    std::error_code ignored;
    const bool all = std::all_of(files.begin(), files.end(),
                                 [&](const std::string& file) { return std::filesystem::exists(file, ignored); });
    if (files.empty() || !all) return {};
    const std::filesystem::path last(files.back());
    const std::string stem = last.stem().string(), prefix = stem.substr(0, stem.find_last_not_of("0123456789") + 1);
    const std::string meant = likelyPattern(last.parent_path(), prefix, last.extension().string());
    return fmt::format(
        "{} more files are named than the tool takes, as by a pattern that the shell expanded; write the "
        "pattern as {} or in quotes",
        files.size(), meant.empty() ? "name.%04d.vdb" : meant);
}

void Tool::share(const Ranks& ranks)
{
    mProcesses = ranks.onHost;
    mIsShared = !ranks.exchange->isAlone();
    mPrints = ranks.exchange->isFirst();
}

int Tool::endBy(int signal) const
{
    if (!mIsShared) dieBy(signal);
    // Another rank may have got the signal, and this one not yet.
    return 128 + (signal != 0 ? signal : SIGTERM);
}

/// Print what was asked for instead of a job. @return the exit status
int Tool::tell(const CLI::Success& asked) const
{
    errno = 0;
    mApp.exit(asked);
    std::cout.flush();
    if (std::cout && std::fflush(stdout) == 0) return status(ExitStatus::kDone);
    if (errno == EPIPE) dieBy(SIGPIPE);
    fmt::print(stderr, "{}: error: standard output: cannot be written: {}\n", mApp.get_name(),
               std::generic_category().message(errno));
    return status(ExitStatus::kCannotWrite);
}

int Tool::run(int argc, char** argv, const std::function<void(Reporter&)>& job)
{
    return run(argc, argv, std::function<ExitStatus(Reporter&)>([&](Reporter& reporter) {
                   job(reporter);
                   return ExitStatus::kDone;
               }));
}

int Tool::run(int argc, char** argv, const std::function<ExitStatus(Reporter&)>& job)
{
    // A closed pipe and a file that is too large become errors of the write, not signals in the middle of a file.
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    catchStopSignals();
    guardAgainstCrashes(mApp.get_name());
    try {
        // CLI11 ignores an empty value or reads it as 0. It mostly comes from an unset variable of a shell.
        for (int i = 1; i < argc; ++i) {
            if (*argv[i] == '\0') throw CLI::ValidationError("an argument is empty; leave it out or give it a value");
        }
        checkOptions(mApp, argc, argv);
        mApp.parse(argc, argv);
    } catch (const CLI::Success& asked) { // --help, --version
        return tell(asked);
    } catch (const CLI::ParseError& error) {
        const std::string expanded = expandedPattern();
        if (!mPrints) return status(ExitStatus::kUsage);
        fmt::print(stderr, "{}: {}\n{} --help lists the options.\n", mApp.get_name(),
                   expanded.empty() ? error.what() : expanded, mApp.get_name());
        return status(ExitStatus::kUsage);
    }

    std::optional<tbb::global_control> threads;
    if (mThreads > 0) threads.emplace(tbb::global_control::max_allowed_parallelism, std::size_t(mThreads));
    limitArenas(threadCount());
    const Console::Level level = !mPrints   ? Console::Level::kSilent
                                 : mQuiet   ? Console::Level::kQuiet
                                 : mVerbose ? Console::Level::kVerbose
                                            : Console::Level::kNormal;
    Console console(mApp.get_name(), level, mOptions->parameters());
    try {
        mOptions->apply();
        limitMemory();
        offerScratch();
        if (mInputs) {
            for (const SequenceParams& input : mInputs())
                warnOfOtherNumbers(input, console);
        }
        if (mVerify) verify(console);
        return status(job(console));
    } catch (const ClosedPipe&) {
        return endBy(stopSignal() != 0 ? stopSignal() : SIGPIPE);
    } catch (const Stopped&) {
        console.say("stopped");
        return endBy(stopSignal());
    } catch (const ParameterError& error) {
        console.error(error.what());
        return status(ExitStatus::kUsage);
    } catch (const InputError& error) {
        console.error(error.what());
        return status(ExitStatus::kBadInput);
    } catch (const OutputError& error) {
        console.error(error.what());
        return status(ExitStatus::kCannotWrite);
    } catch (const std::bad_alloc&) {
        if (const char* const scratch = paging::problem()) {
            console.error(scratch);
            return status(ExitStatus::kCannotWrite);
        }
        console.error(fmt::format("this takes more than the {} of memory that may be used: cut the domain, use fewer "
                                  "threads, or raise --max-memory",
                                  memoryText(double(memoryLimit()))));
        return status(ExitStatus::kBadInput);
    } catch (const std::system_error& error) {
        if (error.code() == std::errc::resource_unavailable_try_again) { // a thread's stack
            console.error(fmt::format("no thread can be started within the {} of memory that may be used: use fewer "
                                      "threads, or raise --max-memory",
                                      memoryText(double(memoryLimit()))));
            return status(ExitStatus::kBadInput);
        }
        console.error(fmt::format("internal error, please report it: {}", error.what()));
    } catch (const std::exception& error) {
        console.error(fmt::format("internal error, please report it: {}", error.what()));
    }
    return status(ExitStatus::kBug);
}

} // namespace vdblic::cli
