#include "vdblic/coherence/coherence_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <cmath>

namespace vdblic {

Parameters parametersOf(CoherenceParams& params)
{
    constexpr double kMostSamples = 1e8;
    return {parameter("samples", "Sample points in a frame.", params.samples, {.limits = {1, kMostSamples}})};
}

void CoherenceParams::validate() const
{
    CoherenceParams copy = *this;
    checkLimits(parametersOf(copy));
    if (!(leastMotion > 0 && std::isfinite(leastMotion))) {
        throw ParameterError(fmt::format("the least motion of {} voxels a step must be above 0", leastMotion));
    }
    pathline.validate();
}

Parameters parametersOf(SequenceCoherenceParams& params)
{
    Parameters input =
        parametersOf(params.flow.input, "VELOCITY",
                     "Velocity sequence: one file, or a pattern: name.%04d.vdb, also ####, @@@@, $F4, <F4>.");
    std::erase_if(input, [](const Parameter& parameter) { return parameter.key == "renumber"; });
    const Parameters own = {
        parameter("textures", "The textures made from it; frames are matched by number.", params.texture,
                  {.option = "TEXTURE", .isRequired = true}),
        parameter("texture", "Name of the texture grid; by default that of vdblic_advect.", params.textureName,
                  {.words = "NAME"}),
        parameter("json", "File to write every figure to.", params.json, {.words = "FILE"}),
    };
    return joined({input, own, parametersOf(params.coherence), parametersOf(params.flow)});
}

void SequenceCoherenceParams::validate() const
{
    flow.validate();
    coherence.validate();
    if (flow.input.pattern == "-" || texture == "-")
        throw ParameterError("paths on standard input cannot be matched by frame; name a file or a pattern");
}

} // namespace vdblic
