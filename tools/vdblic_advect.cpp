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
    tool.options(parametersOf(params),
                 {{"Input", {"frames", "clamp_frames", "renumber", "steady_frames"}},
                  {"Output", {"output", "carry", "derived", "texture_name", "scalars", "precision", "compression"}},
                  {"Texture", {"method", "life_span", "substeps", "alpha", "refine", "noise", "seed"}},
                  {"Streaks", {"spacing", "tail", "emit", "emit_box", "source"}},
                  {"Velocity",
                   {"velocity", "velocity_unit", "velocity_scale", "frame_spacing", "fps", "motion", "voxels_per_frame",
                    "non_finite"}},
                  {"Domain", {"mask", "box", "world_box", "periodic"}},
                  {"Observer", {"frame_velocity", "frame_rotation", "frame_axis", "frame_point", "stay"}},
                  {"Run", {"json", "resume", "restart", "keep_checkpoint"}},
                  {cli::kExpertGroup,
                   {"release_window", "sample_spacing", "tolerance", "sharpen", "noise_share", "interpolation",
                    "preroll", "lead_in", "finish", "checkpoint_every"}}});
    tool.reads([&] { return std::vector<SequenceParams>{params.flow.input}; });
    constexpr double kInFiles = 6; // frames of velocity and the state
    tool.usesScratch(kInFiles, [&] { return params.output; });
    cli::JoinedNumbers arguments(argc, argv, {"--refine", "--spacing", "--frame-velocity"});
    return tool.run(arguments.count(), arguments.arguments(), [&](Reporter& reporter) {
        advectSequence(params, tool.standardInput(), reporter, *ranks.exchange);
    });
}
