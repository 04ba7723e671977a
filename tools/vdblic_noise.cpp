#include "cli/joined_numbers.h"
#include "cli/tool.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/noise/noise_file.h"

#include <vector>

int main(int argc, char** argv)
{
    vdblic::NoiseParams params;
    vdblic::cli::Tool tool("vdblic_noise", "Make white noise, the input of flow textures.");
    tool.options(parametersOf(params));
    tool.reads([&] {
        const auto file = params.like.empty() ? "" : vdblic::parseGridReference(params.like).path.string();
        return std::vector<vdblic::SequenceParams>(file.empty() ? 0 : 1, {file, ""});
    });
    constexpr double kInFiles = 2; // a file, and the voxels that it has
    tool.usesScratch(kInFiles, [&] { return params.output; });
    vdblic::cli::JoinedNumbers arguments(argc, argv, {"--refine"});
    return tool.run(arguments.count(), arguments.arguments(),
                    [&](vdblic::Reporter& reporter) { vdblic::makeNoiseFile(params, reporter); });
}
