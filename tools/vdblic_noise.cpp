#include "cli/tool.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/lic/noise_file.h"

#include <vector>

int main(int argc, char** argv)
{
    vdblic::NoiseParams params;
    vdblic::cli::Tool tool("vdblic_noise", "Make white noise, the input of flow textures.");
    tool.output(params.output, "The .vdb file to write.");
    CLI::Option* like = tool.option("--like", params.like,
                                    "FILE or FILE:GRID whose active voxels and transform to take; by default the first "
                                    "grid in the file that has active voxels.");
    tool.app()
        .add_option("--size", params.size, "Voxels along x, y and z of a box.")
        ->type_name("X Y Z")
        ->excludes(like);
    tool.option("--seed", params.seed, "Another seed gives other noise.");
    tool.skipExisting(params.skipExisting);
    tool.verifies([&] {
        const auto file = params.like.empty() ? "" : vdblic::parseGridReference(params.like).path.string();
        return std::vector<vdblic::SequenceParams>(file.empty() ? 0 : 1, {file, ""});
    });
    return tool.run(argc, argv, [&](vdblic::Reporter& reporter) { vdblic::makeNoiseFile(params, reporter); });
}
