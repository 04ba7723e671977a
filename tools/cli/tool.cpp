#include "cli/tool.h"

#include "cli/console.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/version.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <csignal>
#include <cstdio>
#include <new>
#include <optional>

namespace vdblic::cli {
namespace {

constexpr int kMaxThreads = 1024;

int status(ExitStatus value)
{
    return static_cast<int>(value);
}

/// An empty argument is no number, though CLI11 takes it for 0; an unset variable in a script makes one.
void checkValues(const CLI::App& app)
{
    for (const CLI::Option* option : app.get_options()) {
        if (option->get_type_name() == "TEXT") continue;
        for (const std::string& value : option->results()) {
            if (value.empty()) throw CLI::ValidationError(option->get_name(), "needs a value, not an empty text");
        }
    }
}

} // namespace

Tool::Tool(std::string name, const std::string& description) : mApp(description, std::move(name))
{
    mApp.set_version_flag("--version", std::string(kVersion));
    mApp.add_option("--threads", mThreads,
                    "Threads to compute with; every core by default. Results do not depend on it.")
        ->check(CLI::Range(1, kMaxThreads));
    CLI::Option* quiet = mApp.add_flag("-q,--quiet", mQuiet, "Print errors and warnings only.");
    mApp.add_flag("-v,--verbose", mVerbose, "Print details.")->excludes(quiet);
    mApp.footer("Exit status: 0 done, 2 usage, 3 bad input data, 4 output could not be written, 5 a bug.\n"
                "The path of each finished output is printed on standard output, messages on standard error.");
}

void Tool::inputSequence(const std::string& name, SequenceParams& target, const std::string& help)
{
    mApp.add_option(name, target.pattern,
                    help + " One file, a pattern (name.%04d.vdb, also ####, @@@@, $F4, <F4>), or - for paths on "
                           "standard input.")
        ->required();
    mApp.add_option("--frames", target.frames,
                    "Frames to use: 1-100, 1-100x2 or 1,5,9-20; every frame found by default.");
    mApp.add_flag("--clamp-frames", target.clampFrames,
                  "Leave out frames of --frames that lie beyond the files on disk.");
}

void Tool::output(std::string& target, const std::string& help)
{
    mApp.add_option("-o,--output", target, help)->required();
}

void Tool::skipExisting(bool& target)
{
    mApp.add_flag("--skip-existing", target, "Leave outputs that are there as they are, and print their paths.");
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
    // A closed pipe is met where it is written to, not by dying in the middle of a file.
    std::signal(SIGPIPE, SIG_IGN);
    // So is a file that grew too large.
    std::signal(SIGXFSZ, SIG_IGN);
    try {
        mApp.parse(argc, argv);
        checkValues(mApp);
    } catch (const CLI::Success& asked) { // --help, --version
        return mApp.exit(asked);
    } catch (const CLI::ParseError& error) {
        fmt::print(stderr, "{}: {}\n{} --help lists the options.\n", mApp.get_name(), error.what(), mApp.get_name());
        return status(ExitStatus::kUsage);
    }

    std::optional<tbb::global_control> threads;
    if (mThreads > 0) threads.emplace(tbb::global_control::max_allowed_parallelism, std::size_t(mThreads));
    Console console(mApp.get_name(), mQuiet     ? Console::Level::kQuiet
                                     : mVerbose ? Console::Level::kVerbose
                                                : Console::Level::kNormal);
    try {
        return status(job(console));
    } catch (const ClosedPipe&) {
        return status(ExitStatus::kDone);
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
        console.error("out of memory; use a smaller domain or fewer threads");
    } catch (const std::exception& error) {
        console.error(fmt::format("internal error, please report it: {}", error.what()));
    }
    return status(ExitStatus::kBug);
}

} // namespace vdblic::cli
