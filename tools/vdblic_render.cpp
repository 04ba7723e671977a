#include "cli/picture_groups.h"
#include "cli/ranks.h"
#include "cli/shared_frames.h"
#include "cli/tool.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/render/frames_in_flight.h"
#include "vdblic/render/moment.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/render_sequence.h"

#include <cstdint>
#include <string>
#include <vector>

int main(int argc, char** argv)
{
    vdblic::RenderParams params;
    const vdblic::cli::Ranks ranks = vdblic::cli::startRanks(argc, argv);
    vdblic::cli::Tool tool(ranks.toolName("vdblic_render"), "Ray cast flow textures into images.");
    tool.share(ranks);
    tool.options(parametersOf(params),
                 vdblic::cli::pictureGroups({{"Lines", {"lines", "substeps"}},
                                             {"Output",
                                              {"output", "skip_existing", "keep_going", "aov", "precision", "histogram",
                                               "transfer_out", "film", "fps"}}}));
    constexpr double kInFiles = 8; // bricks and light of a texture
    tool.usesScratch(kInFiles, [&] { return params.outputs.images; });
    tool.reads([&] {
        std::vector<vdblic::SequenceParams> inputs{params.files()};
        if (!params.picture.lines.empty()) {
            inputs.push_back(params.input);
            inputs.back().pattern = params.picture.lines;
        }
        return inputs;
    });
    return tool.run(argc, argv, [&](vdblic::Reporter& reporter) {
        vdblic::Exchange& exchange = *ranks.exchange;
        if (!exchange.isAlone() && (!params.outputs.film.empty() || !params.outputs.histogram.empty())) {
            throw vdblic::ParameterError(
                "a film or a histogram needs all frames, and no rank has them: make it with vdblic_render");
        }
        if (!exchange.isAlone() && params.input.pattern == "-") {
            throw vdblic::ParameterError(
                "frames on standard input cannot be shared out; give a pattern such as name.%04d.vdb");
        }
        vdblic::RenderPlan plan;
        exchange.together([&] { plan = resolve(params); });
        if (!exchange.isFirst()) plan.outputs.transferFunction.clear();
        if (exchange.isAlone() || vdblic::ranksShareFrames(plan, exchange))
            return vdblic::renderSequence(plan, tool.standardInput(), reporter, exchange);
        std::vector<std::int64_t> numbers;
        exchange.together([&] {
            for (const vdblic::Moment& moment : momentsOf(plan))
                numbers.push_back(moment.number);
        });
        vdblic::cli::shareFrames(exchange, numbers, reporter, [&](const std::string& mine, vdblic::Reporter& to) {
            vdblic::RenderPlan share = plan;
            (plan.substeps > 1 ? share.pictures : share.input.frames) = mine;
            vdblic::OneProcess alone;
            vdblic::renderSequence(share, tool.standardInput(), to, alone);
        });
    });
}
