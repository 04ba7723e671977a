#include "cli/tool.h"
#include "vdblic/compare/compare.h"

#include <functional>
#include <string>
#include <vector>

int main(int argc, char** argv)
{
    using namespace vdblic;
    CompareSequencesParams params;
    CompareParams& compare = params.compare;
    std::vector<std::string> ignored;

    cli::Tool tool{"vdblic_diff", "Tell whether two volumes, or two sequences of volumes, agree."};
    CLI::App& app = tool.app();
    app.add_option("A", params.a, "One .vdb file, or a pattern: name.%04d.vdb, also ####, @@@@, $F4, <F4>.")
        ->required();
    app.add_option("B", params.b, "The file or pattern to compare with; frames are matched by number.")->required();
    app.add_option("--frames", params.frames, "Frames to compare: 1-100, 1-100x2 or 1,5,9-20; every frame by default.");
    tool.option("--fail", compare.fail, "Errors up to this are within tolerance [unit of the values]");
    tool.option("--relative", compare.relative, "As are errors up to this share of the larger of |a| and |b|");
    tool.option("--fail-percent", compare.failPercent, "Share of a grid's voxels that may be over tolerance [%]");
    app.add_option("--hard-fail", compare.hardFail, "Yet one error over this fails [unit of the values]");
    app.add_option("--warn", compare.warn, "Errors over this are worth a warning [unit of the values]");
    app.add_flag("--inactive", compare.inactive,
                 "Compare inactive voxels too, where they hold more than the background.");
    app.add_flag("--first", compare.firstOnly, "Stop at the first difference.");
    app.add_option("--ignore-metadata", ignored,
                   "Names of metadata to ignore besides creation details and file statistics; a last * stands for any "
                   "rest.")
        ->delimiter(',')
        ->allow_extra_args(false);
    app.add_option("-o,--output", params.output, "File or pattern to write |A - B| grids to.");
    tool.skipExisting(params.skipExisting);
    app.add_option("--json", params.json, "File to write the whole report to.");
    app.footer("Exit status: 0 the same within tolerance (warnings included), 1 different, 2 usage, 3 bad input data,\n"
               "4 output could not be written, 5 a bug.\n"
               "The report goes to standard error; the path of each finished output is printed on standard output.");
    tool.verifies([&] { return std::vector<SequenceParams>{{params.a, params.frames}, {params.b, params.frames}}; });

    const std::function<cli::ExitStatus(Reporter&)> job = [&](Reporter& reporter) {
        compare.ignoredMetadata.insert(compare.ignoredMetadata.end(), ignored.begin(), ignored.end());
        const SequenceDifference difference = compareSequences(params, reporter);
        return difference.verdict() == Verdict::kDiffers ? cli::ExitStatus::kDiffers : cli::ExitStatus::kDone;
    };
    return tool.run(argc, argv, job);
}
