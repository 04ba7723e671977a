#include "cli/tool.h"
#include "cli/velocity_options.h"
#include "vdblic/coherence/coherence_sequence.h"

#include <vector>

int main(int argc, char** argv)
{
    using namespace vdblic;
    SequenceCoherenceParams params;
    FlowSequenceParams& flow = params.flow;

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
    const cli::VelocityOptions velocity(tool, flow.velocity, flow.frameSpacing);
    app.add_option("--json", params.json, "File to write every figure to.");
    app.add_option("-o,--output", params.plot, "SVG file to plot the autocorrelations to.");
    app.footer("Exit status: 0 done, 2 usage, 3 bad input data, 4 output could not be written, 5 a bug.\n"
               "The report goes to standard error; the path of each finished output is printed on standard output.");
    tool.verifies([&] { return std::vector<SequenceParams>{flow.input, {params.texture, flow.input.frames}}; });

    return tool.run(argc, argv, [&](Reporter& reporter) {
        velocity.apply();
        coherenceOfSequence(params, reporter);
    });
}
