#include "vdblic/coherence/coherence_params.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/output_pattern.h"

#include <fmt/format.h>

#include <cmath>

namespace vdblic {

Parameters parametersOf(CoherenceParams& params)
{
    constexpr double kMostSamples = 1e8;
    return {parameter({.key = "samples", .text = "Points a frame is looked at.", .limits = {1, kMostSamples}},
                      params.samples)};
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
    const Parameters own = {
        parameter({.key = "input",
                   .text = "Velocity sequence: one file, or a pattern: name.%04d.vdb, also ####, @@@@, $F4, <F4>.",
                   .option = "VELOCITY",
                   .isRequired = true,
                   .isFile = true},
                  params.flow.input.pattern),
        parameter({.key = "texture",
                   .text = "The textures made from it; frames are matched by number.",
                   .option = "TEXTURE",
                   .isRequired = true,
                   .isFile = true},
                  params.texture),
        parameter({.key = "frames", .text = "Frames to measure: 1-100, 1-100x2 or 1,5,9-20; every frame by default."},
                  params.flow.input.frames),
        parameter(
            {.key = "clamp_frames", .text = "Leave out frames of the selection that lie beyond the files on disk."},
            params.flow.input.clampFrames),
        parameter({.key = "texture_name",
                   .text = "Name of the texture grid; by default that of vdblic_advect.",
                   .option = "--texture",
                   .words = "NAME"},
                  params.textureName),
        parameter({.key = "json", .text = "File to write every figure to.", .words = "FILE", .isFile = true},
                  params.json),
        parameter({.key = "plot",
                   .text = "SVG file to plot the autocorrelations to.",
                   .option = "-o,--output",
                   .words = "FILE",
                   .isFile = true},
                  params.plot),
    };
    return joined({own, parametersOf(params.coherence), parametersOf(params.flow)});
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
