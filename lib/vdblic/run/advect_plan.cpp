#include "vdblic/run/advect_plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace vdblic {

AdvectPlan resolve(AdvectParams params, const FramesAround& around)
{
    const TextureMethod& method = params.method();
    const std::vector<std::int64_t>& before = around.before;
    const std::size_t wanted = std::size_t(params.leadIn.value_or(method.leadIn(params)));
    const std::size_t leadIn = std::min(wanted, before.size()), framesBefore = before.size() - leadIn;
    const bool standsIn = leadIn > 0 && framesBefore > 0;
    const int preroll = params.preroll.value_or(standsIn ? 0 : method.preroll(params));
    const int finish = params.finish.value_or(method.finish);
    SequenceParams input = params.flow.input;
    if (leadIn > 0) {
        const std::vector<std::int64_t> frames(before.end() - std::ptrdiff_t(leadIn), before.end());
        input.frames = fmt::format("{},{}", fmt::join(frames, ","), input.frames);
    }
    return {std::move(params), std::move(input), preroll, int(leadIn), int(framesBefore), finish};
}

AdvectParams chosenParams(const AdvectPlan& plan)
{
    AdvectParams chosen = plan.params;
    chosen.preroll = plan.preroll;
    chosen.leadIn = plan.leadIn;
    chosen.finish = plan.finish;
    return chosen;
}

std::string leadInText(const AdvectPlan& plan)
{
    if (plan.leadIn == 0) return {};
    const std::vector<std::int64_t> frames = selectedFrames(plan.input);
    const std::int64_t first = frames.front(), last = frames[std::size_t(plan.leadIn) - 1];
    const std::string which =
        first == last ? fmt::format("frame {} is", first) : fmt::format("frames {} to {} are", first, last);
    const std::string more = plan.framesBefore == 0
                                 ? ""
                                 : fmt::format("; with `lead_in` {} the textures would be those of a run over all "
                                               "frames",
                                               plan.leadIn + plan.framesBefore);
    return fmt::format("{} computed first and not written{}", which, more);
}

std::uint64_t AdvectPlan::prerollSteps() const
{
    return std::uint64_t(preroll) * std::uint64_t(substeps());
}

std::uint64_t AdvectPlan::warmUpSteps() const
{
    return prerollSteps() + std::uint64_t(leadIn) * std::uint64_t(substeps());
}

std::uint64_t AdvectPlan::framesDone(std::uint64_t steps) const
{
    return (std::max(steps, prerollSteps()) - prerollSteps()) / std::uint64_t(substeps());
}

std::uint64_t AdvectPlan::texturesDone(std::uint64_t steps) const
{
    return std::max(steps, warmUpSteps()) - warmUpSteps();
}

int AdvectPlan::substep(std::uint64_t steps) const
{
    return int((std::max(steps, prerollSteps()) - prerollSteps()) % std::uint64_t(substeps()));
}

std::size_t AdvectPlan::textures(std::size_t frames) const
{
    const std::size_t written = frames - std::min(frames, std::size_t(leadIn));
    return written > 0 ? (written - 1) * std::size_t(substeps()) + 1 : 0;
}

} // namespace vdblic
