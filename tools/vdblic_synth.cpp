#include "cli/tool.h"
#include "vdblic/field/synth.h"

#include <fmt/format.h>

int main(int argc, char** argv)
{
    vdblic::SynthParams params;
    vdblic::cli::Tool tool("vdblic_synth", "Make a velocity sequence of an analytic, unsteady flow.");
    tool.app().add_option("FLOW", params.flow, "Name of the flow; --list shows them.")->required();
    tool.output(params.output, "The files to write, as a pattern such as velocity.%04d.vdb.");
    tool.app().add_option("--size", params.size, "Voxels along x, y and z.")->type_name("X Y Z")->required();
    tool.app()
        .add_option("--frames", params.frames, "Frames to make: 1-100, 1-100x2 or 1,5,9-20; frame 1 is at time 0.")
        ->required();
    tool.option("--dt", params.dt,
                "Seconds from one frame number to the next. With the default a flow moves by about 3 voxels a frame.");
    tool.option("--voxel-size", params.voxelSize, "Voxel size in world units; velocities are in these per second.");
    const auto list = [] {
        for (const vdblic::AnalyticFlow& flow : vdblic::analyticFlows()) {
            fmt::print("{:<10}{}\n", flow.name, flow.description);
        }
        throw CLI::Success{}; // before the required options are missed
    };
    tool.app().add_flag_callback("--list", list, "Name the flows, each with a line about it, and exit.");
    return tool.run(argc, argv, [&](vdblic::Reporter& reporter) { vdblic::synthSequence(params, reporter); });
}
