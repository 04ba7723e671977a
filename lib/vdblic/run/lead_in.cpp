#include "vdblic/run/lead_in.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdblic {

AdvectParams withLeadIn(AdvectParams params, Reporter& reporter)
{
    const std::vector<std::int64_t> before = framesAround(params.flow.input).before;
    const std::size_t count = std::min(std::size_t(params.leadInFrames()), before.size());
    params.leadIn = int(count);
    params.framesBefore = int(before.size() - count);
    if (count == 0) return params;
    if (params.framesBefore > 0) params.preroll = params.preroll.value_or(0);
    const std::vector<std::int64_t> frames(before.end() - std::ptrdiff_t(count), before.end());
    params.flow.input.frames = fmt::format("{},{}", fmt::join(frames, ","), params.flow.input.frames);
    const std::string more = params.framesBefore == 0
                                 ? ""
                                 : fmt::format("; with `lead_in` {} the textures would be those of a "
                                               "run over all frames",
                                               before.size());
    const std::string which = count == 1 ? fmt::format("frame {} is", frames.front())
                                         : fmt::format("frames {} to {} are", frames.front(), frames.back());
    reporter.say(fmt::format("{} computed first and not written{}", which, more));
    return params;
}

} // namespace vdblic
