#include "cli/tool.h"
#include "vdblic/compare/compare.h"

#include <functional>
#include <string>
#include <vector>

int main(int argc, char** argv)
{
    using namespace vdblic;
    CompareSequencesParams params;

    cli::Tool tool{"vdblic_diff", "Tell whether two volumes, or two sequences of volumes, agree."};
    CLI::App& app = tool.app();
    tool.options(parametersOf(params));
    app.footer("Exit status: 0 the same within tolerance, 1 different, 2 usage, 3 bad input data,\n"
               "4 output could not be written, 5 a bug.\n"
               "The report goes to standard error; the path of each finished output is printed on standard output.");
    constexpr double kInFiles = 4; // two volumes, and where they differ
    tool.usesScratch(kInFiles);
    tool.reads([&] { return std::vector<SequenceParams>{{params.a, params.frames}, {params.b, params.frames}}; });

    const std::function<cli::ExitStatus(Reporter&)> job = [&](Reporter& reporter) {
        const SequenceDifference difference = compareSequences(params, reporter);
        return difference.verdict() == Verdict::kDiffers ? cli::ExitStatus::kDiffers : cli::ExitStatus::kDone;
    };
    return tool.run(argc, argv, job);
}
