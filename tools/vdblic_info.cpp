#include "cli/option_names.h"
#include "cli/tool.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/printable.h"
#include "vdblic/film/film_cost.h"
#include "vdblic/film/film_plan.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/frame_pattern.h"
#include "vdblic/io/input_files.h"
#include "vdblic/run/advect_params.h"
#include "vdblic/run/sequence_info.h"

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <vector>

namespace {

using namespace vdblic;

/// Commands that show a velocity, each with a word before it.
std::vector<std::string> commandsFor(const SequenceInfo& info, const SequenceParams& input)
{
    if (!info.velocity || !info.damaged.empty()) return {};
    const std::string frames = input.frames.empty() ? "" : " --frames " + shellWord(input.frames);
    const std::string film = fmt::format("vdblic_film {}{} -o flow", shellWord(info.pattern), frames);
    std::vector<std::string> lines{fmt::format("  film: {}.mp4", film), fmt::format("  still: {}.png", film)};
    if (!info.velocity->motion) return lines;
    try {
        FilmParams params{.input = input, .output = "flow.mp4"};
        const FilmPlan plan = planFilm(params, info);
        lines.push_back("  the film takes about " + costText(plan));
        for (const std::string& command : commandsOf(plan, ""))
            lines.push_back("  the film step by step: " + command);
    } catch (const InputError&) { // the advice names the error
        lines.clear();
    }
    return lines;
}

} // namespace

int main(int argc, char** argv)
{
    SequenceInfoParams params;
    std::vector<std::string> patterns;
    std::string json;

    cli::Tool tool("vdblic_info", "Tell what a sequence holds, and what its texture will need.");
    CLI::App& app = tool.app();
    app.add_option("SEQUENCE", patterns,
                   "Files or patterns: name.%04d.vdb, also ####, @@@@, $F4, <F4>. Files of one name that differ in "
                   "their number are one sequence.")
        ->required();
    app.add_option("--json", json, "File to write the report to.");
    tool.options(parametersOf(params));
    app.footer("Exit status: 0 done, 2 usage, 3 bad input data, 4 output could not be written, 5 a bug.\n"
               "The report goes to standard error; the path of each finished output is printed on standard output.");

    constexpr double kInFiles = 3; // a file, and the velocity that it holds
    tool.usesScratch(kInFiles);
    return tool.run(argc, argv, [&](Reporter& reporter) {
        if (!json.empty()) {
            InputFiles inputs;
            for (const std::string& pattern : patterns) {
                const FramePattern files(pattern);
                inputs.add(pattern);
                for (const std::int64_t frame : files.framesOnDisk())
                    inputs.add(files.path(frame));
            }
            inputs.check(json);
            checkReport(json);
        }
        AdvectParams run;
        const Parameters advised = parametersOf(run); // parameters that the advice names
        std::vector<SequenceInfo> sequences;
        const std::string frames = params.flow.input.frames;
        for (const SequenceParams& sequence : sequencesNamed(patterns)) {
            params.flow.input.pattern = sequence.pattern;
            params.flow.input.frames = frames.empty() ? sequence.frames : frames;
            warnOfOtherNumbers(params.flow.input, reporter);
            SequenceInfo info = inspectSequence(params, reporter);
            for (std::string& advice : info.advice)
                advice = cli::withOptionNames(advice, advised);
            for (const std::string& line : infoLines(info))
                reporter.say(line);
            for (const std::string& line : commandsFor(info, params.flow.input))
                reporter.say(line);
            sequences.push_back(std::move(info));
        }
        if (!json.empty() && writeReport(json, toJson(sequences))) reporter.finished(json);
        for (const SequenceInfo& info : sequences) {
            if (!info.damaged.empty())
                throw InputError(fmt::format("{}: {} of {} files cannot be read; the report says why", info.pattern,
                                             info.damaged.size(), info.frames.size()));
        }
    });
}
