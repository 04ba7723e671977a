#include "cli/tool.h"
#include "vdblic/coherence/coherence_sequence.h"

#include <vector>

int main(int argc, char** argv)
{
    using namespace vdblic;
    SequenceCoherenceParams params;

    cli::Tool tool("vdblic_coherence", "Measure how well a texture sequence shows the flow it was made from.");
    CLI::App& app = tool.app();
    tool.options(parametersOf(params));
    app.footer("Exit status: 0 done, 2 usage, 3 bad input data, 4 output could not be written, 5 a bug.\n"
               "The report goes to standard error; the path of each finished output is printed on standard output.");
    constexpr double kInFiles = 8; // frames of velocity, smoothed textures and bricks of both
    tool.usesScratch(kInFiles);
    tool.reads([&] {
        return std::vector<SequenceParams>{params.flow.input, {params.texture, params.flow.input.frames}};
    });

    return tool.run(argc, argv, [&](Reporter& reporter) { coherenceOfSequence(params, reporter); });
}
