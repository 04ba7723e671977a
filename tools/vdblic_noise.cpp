#include "cli/refinement_option.h"
#include "cli/tool.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/noise/noise_file.h"

#include <vector>

int main(int argc, char** argv)
{
    vdblic::NoiseParams params;
    std::vector<int> refine{1};
    vdblic::cli::Tool tool("vdblic_noise", "Make white noise, the input of flow textures.");
    tool.output(params.output, "The .vdb file to write.");
    CLI::Option* like = tool.option("--like", params.like,
                                    "FILE or FILE:GRID whose active voxels and transform to take; by default the first "
                                    "grid in the file that has active voxels.");
    tool.app()
        .add_option("--size", params.size, "Voxels along x, y and z of a box.")
        ->type_name("X Y Z")
        ->excludes(like);
    tool.option("--refine", refine,
                "With --like, voxels of the noise along each axis in a voxel of the grid: N or NX NY NZ, 1 to 16.")
        ->delimiter(',');
    tool.option("--seed", params.seed, "Another seed gives other noise.");
    tool.skipExisting(params.skipExisting);
    tool.verifies([&] {
        const auto file = params.like.empty() ? "" : vdblic::parseGridReference(params.like).path.string();
        return std::vector<vdblic::SequenceParams>(file.empty() ? 0 : 1, {file, ""});
    });
    return tool.run(argc, argv, [&](vdblic::Reporter& reporter) {
        params.refinement = vdblic::cli::refinementOf(refine);
        vdblic::makeNoiseFile(params, reporter);
    });
}
