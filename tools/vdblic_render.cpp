#include "cli/ranks.h"
#include "cli/shared_frames.h"
#include "cli/tool.h"
#include "vdblic/core/errors.h"
#include "vdblic/render/frames_in_flight.h"
#include "vdblic/render/render_sequence.h"

#include <vector>

int main(int argc, char** argv)
{
    vdblic::RenderParams params = vdblic::defaultRenderParams();
    const vdblic::cli::Ranks ranks = vdblic::cli::startRanks(argc, argv);
    vdblic::cli::Tool tool(ranks.toolName("vdblic_render"), "Ray cast flow textures into images.");
    tool.share(ranks);
    tool.options(parametersOf(params));
    constexpr double kInFiles = 8; // bricks and light of a texture
    tool.usesScratch(kInFiles, [&] { return params.output; });
    tool.reads([&] { return std::vector<vdblic::SequenceParams>{params.input}; });
    return tool.run(argc, argv, [&](vdblic::Reporter& reporter) {
        params.rays.layers = !params.exr.layers.empty();
        if (!ranks.exchange->isAlone() && (!params.film.empty() || !params.histogram.empty())) {
            throw vdblic::ParameterError(
                "a film or a histogram is of all frames, which no rank has: leave it out here, "
                "and make it by vdblic_render");
        }
        if (!ranks.exchange->isFirst()) params.transferOut.clear();
        if (vdblic::ranksShareFrames(params, *ranks.exchange))
            return vdblic::renderSequence(params, tool.standardInput(), reporter, *ranks.exchange);
        vdblic::cli::shareFrames(*ranks.exchange, params.input, reporter,
                                 [&](const vdblic::SequenceParams& input, vdblic::Reporter& to) {
                                     vdblic::RenderParams share = params;
                                     share.input = input;
                                     vdblic::renderSequence(share, tool.standardInput(), to);
                                 });
    });
}
