#include "cli/tool.h"

#include "cli/console.h"
#include "cli/parameter_options.h"
#include "cli/stop_signals.h"
#include "vdblic/core/crash_guard.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/paging.h"
#include "vdblic/core/printable.h"
#include "vdblic/core/scratch_memory.h"
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
#include <filesystem>
#include <functional>
#include <iostream>
#include <optional>
#include <string_view>
#include <sys/resource.h>
#include <system_error>
#include <vector>

namespace vdblic::cli {
namespace {

constexpr int kMaxThreads = 1024;
constexpr char kSeparator = '\0'; // in no argument
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
    setMemoryOption();
    mApp.add_option("--max-memory", mMaxMemory,
                    "Memory limit of the tool, such as 800M or 16G; what the machine has by default.")
        ->type_name("SIZE");
    CLI::Option* quiet = mApp.add_flag("-q,--quiet", mQuiet, "Print errors and warnings only.");
    mApp.add_flag("-v,--verbose", mVerbose, "Print details.")->excludes(quiet);
    mApp.footer("Exit status: 0 done, 2 usage, 3 bad input data, 4 output could not be written, 5 a bug; after a\n"
                "signal 128 and its number.\n"
                "The path of each finished output is printed on standard output, messages on standard error.");
}

void Tool::options(Parameters parameters, std::vector<OptionGroup> groups)
{
    mOptions.emplace(mApp, std::move(parameters), std::move(groups));
    answers("--parameters", "Print the options as JSON, for programs, and exit.", [this] {
        return mOptions->toJson();
    })->group(kExpertGroup);
}

CLI::Option* Tool::answers(const std::string& flag, const std::string& help, std::function<std::string()> text)
{
    const auto answer = [this, text = std::move(text)] {
        mAnswer = text();
        throw CLI::Success{}; // before the required options are missed
    };
    return mApp.add_flag_callback(flag, answer, help);
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

/// The number of threads requested, or as many as the system can start: TBB would abort the process.
std::size_t Tool::threadsToUse(Reporter& reporter) const
{
    constexpr std::size_t kOthers = 2; // one reads ahead, one writes
    const std::size_t wanted = mThreads > 0 ? std::size_t(mThreads) : threadCount();
    const std::size_t more = startableThreads(wanted - 1 + kOthers);
    if (more == wanted - 1 + kOthers) return wanted;
    const std::size_t used = 1 + more - std::min(more, kOthers);
    if (used < wanted) {
        reporter.say(fmt::format("{} of {} threads compute: no more can be started; raise --max-memory, which includes "
                                 "8 MiB a thread, or allow the user more processes (ulimit -u)",
                                 used, wanted));
    }
    return used;
}

void Tool::usesScratch(double inFiles, std::function<std::string()> output)
{
    mInFiles = inFiles;
    mOutput = std::move(output);
    mApp.add_option("--scratch", mScratch,
                    fmt::format("Folder for the scratch file of a job beyond --max-memory; {} by default.",
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
    paging::setMemory(*new ScratchMemory(folder.empty() ? "." : folder, memoryLimit(), mInFiles)); // never freed
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

/// The message if the shell expanded a pattern into file names; empty if it did not.
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
    if (!ranks.exchange->isAlone()) mExchange = ranks.exchange.get();
    mProcesses = ranks.onHost;
    mIsShared = !ranks.exchange->isAlone();
    mPrints = ranks.exchange->isFirst();
}

/// Set the parameters, and check that all ranks have the same. @throws ParameterError
void Tool::apply()
{
    if (!mExchange) return mOptions->apply();
    mExchange->together([&] { mOptions->apply(); });
    const auto textOf = [](const Parameter& parameter) {
        return fmt::format("{}{}{}{}", parameter.key, kSeparator, parameter.value(), kSeparator);
    };
    std::string own;
    for (const Parameter& parameter : mOptions->parameters())
        own += textOf(parameter);
    const std::string first = mExchange->broadcast(mExchange->isFirst() ? own : "");
    mExchange->together([&] {
        std::string_view rest = first;
        for (const Parameter& parameter : mOptions->parameters()) {
            const std::string text = textOf(parameter);
            if (!rest.starts_with(text)) {
                rest.remove_prefix(std::min(rest.size(), parameter.key.size() + 1));
                throw ParameterError(fmt::format("`{}` is '{}' at rank {} and '{}' at rank 0; give all ranks the same "
                                                 "options",
                                                 parameter.key, parameter.value(), mExchange->rank(),
                                                 rest.substr(0, rest.find(kSeparator))));
            }
            rest.remove_prefix(text.size());
        }
    });
}

int Tool::endBy(int signal) const
{
    if (!mIsShared) dieBy(signal);
    // Another rank may have got the signal, and this one not yet.
    return 128 + (signal != 0 ? signal : SIGTERM);
}

/// Print the answer to --help, --version or a flag of answers(). @return the exit status
int Tool::tell(const CLI::Success& asked) const
{
    errno = 0;
    mApp.exit(asked);
    std::cout << mAnswer << std::flush;
    if (std::cout && std::fflush(stdout) == 0) return status(ExitStatus::kDone);
    if (errno == EPIPE) dieBy(SIGPIPE);
    printMessage(fmt::format("{}: error: standard output: cannot be written: {}\n", mApp.get_name(),
                             std::generic_category().message(errno)));
    return status(ExitStatus::kCannotWrite);
}

int Tool::run(int argc, char** argv, const std::function<void(Reporter&)>& job)
{
    return run(argc, argv, std::function<ExitStatus(Reporter&)>([&](Reporter& reporter) {
                   job(reporter);
                   return ExitStatus::kDone;
               }));
}

/// @return the exit status if the command line asks for no job, or has a mistake
std::optional<int> Tool::parse(int argc, char** argv)
{
    try {
        // CLI11 ignores an empty value or reads it as 0. It mostly comes from an unset variable of a shell.
        for (int i = 1; i < argc; ++i) {
            if (*argv[i] == '\0') throw CLI::ValidationError("an argument is empty; leave it out or give it a value");
        }
        checkOptions(mApp, argc, argv);
        mApp.parse(argc, argv);
    } catch (const CLI::Success& asked) { // --help, --version
        mRefusal = "it was asked for help, or for another answer";
        return tell(asked);
    } catch (const CLI::ParseError& error) {
        const std::string expanded = expandedPattern();
        mRefusal = printable(expanded.empty() ? error.what() : expanded);
        if (!mPrints) return status(ExitStatus::kUsage);
        printMessage(fmt::format("{}: {}\n{} --help lists the options.\n", mApp.get_name(), mRefusal, mApp.get_name()));
        return status(ExitStatus::kUsage);
    }
    return std::nullopt;
}

/// Stop all ranks if one rank's command line requests no job, or has a mistake. @param told of this rank's
/// @return the status to end with. @throws ParameterError at rank 0, which prints
std::optional<int> Tool::agreed(std::optional<int> told)
{
    if (!mExchange || !mExchange->any(told.has_value())) return told;
    const std::vector<Exchange::Bytes> refusals = mExchange->gather(told ? mRefusal : "");
    if (told || !mPrints) return told.value_or(status(ExitStatus::kUsage));
    const auto found = std::find_if_not(refusals.begin(), refusals.end(), std::mem_fn(&Exchange::Bytes::empty));
    throw ParameterError(fmt::format("rank {}: {}; give all ranks the same options", found - refusals.begin(), *found));
}

/// Apply the options common to all tools.
void Tool::prepare(Console& console) const
{
    limitMemory();
    // Never destroyed: at its end TBB would start the threads that it was denied.
    static const auto* const kThreads =
        new tbb::global_control(tbb::global_control::max_allowed_parallelism, threadsToUse(console));
    (void)kThreads;
    limitArenas(threadCount());
    offerScratch();
    if (mInputs) {
        for (const SequenceParams& input : mInputs())
            warnOfOtherNumbers(input, console);
    }
    if (mVerify) verify(console);
}

int Tool::run(int argc, char** argv, const std::function<ExitStatus(Reporter&)>& job)
{
    holdStandardStreams();
    // A closed pipe and a file that is too large become errors of the write, not signals in the middle of a file.
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    catchStopSignals();
    guardAgainstCrashes(mApp.get_name(), {status(ExitStatus::kBadInput), status(ExitStatus::kCannotWrite)});
    Console console(mApp.get_name(), mPrints ? Console::Level::kNormal : Console::Level::kSilent,
                    mOptions->parameters());
    try {
        if (const std::optional<int> told = agreed(parse(argc, argv))) return *told;
        if (mPrints && mQuiet) console.setLevel(Console::Level::kQuiet);
        if (mPrints && mVerbose) console.setLevel(Console::Level::kVerbose);
        apply();
        const auto begin = [&] { prepare(console); };
        mExchange ? mExchange->together(begin) : begin();
        return status(job(console));
    } catch (const ClosedPipe&) {
        return endBy(stopSignal() != 0 ? stopSignal() : SIGPIPE);
    } catch (const Stopped&) {
        console.say("stopped");
        return endBy(stopSignal());
    } catch (...) {
        return status(tellFailure(console));
    }
}

} // namespace vdblic::cli
