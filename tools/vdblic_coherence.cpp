#include "cli/tool.h"
#include "vdblic/lic/coherence_sequence.h"

#include <optional>
#include <string>
#include <vector>

int main(int argc, char** argv)
{
    using namespace vdblic;
    SequenceCoherenceParams params;
    FlowSequenceParams& flow = params.flow;
    std::string unit;
    std::optional<double> fps;

    cli::Tool tool("vdblic_coherence", "Measure how well a texture sequence shows the flow it was made from.");
    CLI::App& app = tool.app();
    app.add_option("VELOCITY", flow.input.pattern,
                   "Velocity sequence: one file, or a pattern: name.%04d.vdb, also ####, @@@@, $F4, <F4>.")
        ->required();
    app.add_option("TEXTURE", params.texture, "The textures made from it; frames are matched by number.")->required();
    app.add_option("--frames", flow.input.frames,
                   "Frames to measure: 1-100, 1-100x2 or 1,5,9-20; every frame by default.");
    app.add_flag("--clamp-frames", flow.input.clampFrames,
                 "Leave out frames of --frames that lie beyond the files on disk.");
    app.add_option("--texture", params.textureName, "Name of the texture grid; by default that of vdblic_advect.");
    tool.option("--samples", params.coherence.samples, "Points a frame is looked at.");
    tool.option("--velocity", flow.velocity.grid, "Name of the velocity grid, or of three scalar grids.");
    tool.option("--velocity-unit", unit,
                "world/s, world/frame, voxel/s or voxel/frame; world/s unless the file is known.");
    tool.option("--velocity-scale", flow.velocity.scale, "Factor on the velocities.");
    auto* dt = tool.option("--dt", flow.frameSpacing,
                           "Seconds between the frames on disk; from the files' metadata by default, else 1/24.");
    tool.option("--fps", fps, "Frames per second, instead of --dt.")->excludes(dt);
    app.add_option("--json", params.json, "File to write every figure to.");
    app.add_option("-o,--output", params.plot, "SVG file to plot the autocorrelations to.");
    app.footer("Exit status: 0 done, 2 usage, 3 bad input data, 4 output could not be written, 5 a bug.\n"
               "The report goes to standard error; the path of each finished output is printed on standard output.");
    tool.verifies([&] { return std::vector<SequenceParams>{flow.input, {params.texture, flow.input.frames}}; });

    return tool.run(argc, argv, [&](Reporter& reporter) {
        if (!unit.empty()) flow.velocity.unit = parseVelocityUnit(unit);
        if (fps) flow.frameSpacing = 1 / *fps;
        coherenceOfSequence(params, reporter);
    });
}
