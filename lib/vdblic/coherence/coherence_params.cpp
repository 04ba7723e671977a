#include "vdblic/coherence/coherence_params.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/output_pattern.h"

#include <fmt/format.h>

#include <cmath>

namespace vdblic {

void CoherenceParams::validate() const
{
    constexpr int kMostSamples = 100'000'000;
    if (samples < 1 || samples > kMostSamples) {
        throw ParameterError(fmt::format("{} samples a frame must lie between 1 and {}", samples, kMostSamples));
    }
    if (!(leastMotion > 0 && std::isfinite(leastMotion))) {
        throw ParameterError(fmt::format("the least motion of {} voxels a step must be above 0", leastMotion));
    }
    pathline.validate();
}

void SequenceCoherenceParams::validate() const
{
    flow.validate();
    coherence.validate();
    if (flow.input.pattern == "-" || texture == "-")
        throw ParameterError("paths on standard input cannot be matched by frame; name a file or a pattern");
    if (!plot.empty()) checkExtension(plot, {".svg"});
    if (!json.empty() && json == plot) {
        throw ParameterError(fmt::format("'{}' cannot be both the figures and the plot; name two files", json));
    }
}

} // namespace vdblic
