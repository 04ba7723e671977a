#include "vdblic/run/advect_params.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/derived_grids.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/lic/finish.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

namespace vdblic {
namespace {

constexpr int kMaxPreroll = 10000; // and of a lead-in

} // namespace

void AdvectParams::validate() const
{
    flow.validate();
    checkExtension(output, {".vdb"});
    texture.validate();
    FinishParams{finishTaps()}.validate();
    if (preroll && (*preroll < 0 || *preroll > kMaxPreroll)) {
        throw ParameterError(fmt::format("preroll {} must lie between 0 and {}", *preroll, kMaxPreroll));
    }
    if (leadIn && (*leadIn < 0 || *leadIn > kMaxPreroll)) {
        throw ParameterError(fmt::format("a lead-in of {} frames must lie between 0 and {}", *leadIn, kMaxPreroll));
    }
    if (checkpointEvery && (*checkpointEvery < 0 || std::size_t(*checkpointEvery) > kMaxFrames)) {
        throw ParameterError(
            fmt::format("a checkpoint every {} frames cannot be; 0 to {}", *checkpointEvery, kMaxFrames));
    }
    if (resume && restart) throw ParameterError("`resume` and `restart` exclude each other");
    if (keepCheckpoint && checkpointEvery == 0) {
        throw ParameterError("`keep_checkpoint` needs checkpoints; leave out `checkpoint_every` 0");
    }
    checkDerivedNames(derived);
    const auto isOutput = [&](const std::string& name) {
        return name == "magnitude" || std::find(derived.begin(), derived.end(), name) != derived.end();
    };
    if (textureName.empty() || isOutput(textureName)) {
        throw ParameterError(fmt::format("'{}' cannot be the texture's name", textureName));
    }
    for (const std::string& name : flow.velocity.carry) {
        if (name != textureName && !isOutput(name)) continue;
        throw ParameterError(fmt::format("the grid '{}' to carry along has the name of an output; leave one of the two "
                                         "out, or give `texture_name` another",
                                         name));
    }
}

int AdvectParams::prerollFrames() const
{
    return preroll.value_or(isSteady(texture.method) ? 0 : texture.lifeSpan);
}

std::uint64_t AdvectParams::prerollSteps() const
{
    return std::uint64_t(prerollFrames()) * std::uint64_t(texture.substeps);
}

int AdvectParams::leadInFrames() const
{
    constexpr int kLifeSpans = 2; // measured: docs/reports/quality.md
    return leadIn.value_or(isSteady(texture.method) ? 0 : kLifeSpans * texture.lifeSpan);
}

int AdvectParams::finishTaps() const
{
    const bool isPublished = isSteady(texture.method) || texture.method == TextureMethod::kAuflic2004;
    return finish.value_or(isPublished ? 0 : FinishParams{}.taps);
}

std::uint64_t AdvectParams::warmUpSteps() const
{
    return prerollSteps() + std::uint64_t(leadIn.value_or(0)) * std::uint64_t(texture.substeps);
}

std::uint64_t AdvectParams::framesDone(std::uint64_t steps) const
{
    return (std::max(steps, prerollSteps()) - prerollSteps()) / std::uint64_t(texture.substeps);
}

std::uint64_t AdvectParams::texturesDone(std::uint64_t steps) const
{
    return std::max(steps, warmUpSteps()) - warmUpSteps();
}

int AdvectParams::substep(std::uint64_t steps) const
{
    return int((std::max(steps, prerollSteps()) - prerollSteps()) % std::uint64_t(texture.substeps));
}

std::size_t AdvectParams::textures(std::size_t frames) const
{
    return frames > 0 ? (frames - 1) * std::size_t(texture.substeps) + 1 : 0;
}

} // namespace vdblic
