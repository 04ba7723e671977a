#include "cli/joined_numbers.h"
#include "cli/ranks.h"
#include "cli/tool.h"
#include "vdblic/run/advect.h"

#include <vector>

int main(int argc, char** argv)
{
    using namespace vdblic;
    AdvectParams params;
    const cli::Ranks ranks = cli::startRanks(argc, argv);
    cli::Tool tool(ranks.toolName("vdblic_advect"), "Compute flow textures from a velocity sequence.");
    tool.share(ranks);
    tool.options(parametersOf(params));
    tool.reads([&] { return std::vector<SequenceParams>{params.flow.input}; });
    constexpr double kInFiles = 6; // frames of velocity and the state
    tool.usesScratch(kInFiles, [&] { return params.output; });
    cli::JoinedNumbers arguments(argc, argv, {"--refine", "--spacing"});
    return tool.run(arguments.count(), arguments.arguments(), [&](Reporter& reporter) {
        advectSequence(params, tool.standardInput(), reporter, *ranks.exchange);
    });
}
