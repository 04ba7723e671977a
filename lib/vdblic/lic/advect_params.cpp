#include "vdblic/lic/advect_params.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/derived_grids.h"
#include "vdblic/io/file_stamp.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/lic/flow_sequence.h"

namespace vdblic {
namespace {

constexpr int kMaxPreroll = 10000;

std::string_view methodName(const AdvectParams& params)
{
    return params.steady ? "lic" : params.scatter.method == ScatterMethod::kAuflic ? "auflic" : "uflic";
}

template<typename T>
std::string textOf(const std::optional<T>& value)
{
    return value ? fmt::format("{}", *value) : "";
}

std::string textOf(const std::vector<std::string>& names)
{
    return fmt::format("{}", fmt::join(names, ","));
}

template<typename T, std::size_t kCount>
std::string textOf(const std::optional<std::array<T, kCount>>& values)
{
    return values ? fmt::format("{}", fmt::join(*values, " ")) : "";
}

} // namespace

void AdvectParams::validate() const
{
    FlowSequenceParams{input, velocity, frameSpacing, domain}.validate();
    scatter.validate();
    feedback.validate();
    if (preroll && (*preroll < 0 || *preroll > kMaxPreroll)) {
        throw ParameterError(fmt::format("preroll {} must lie between 0 and {}", *preroll, kMaxPreroll));
    }
    if (checkpointEvery && (*checkpointEvery < 0 || std::size_t(*checkpointEvery) > kMaxFrames)) {
        throw ParameterError(
            fmt::format("a checkpoint every {} frames cannot be; 0 to {}", *checkpointEvery, kMaxFrames));
    }
    checkDerivedNames(derived);
    const auto isOutput = [&](const std::string& name) {
        return name == "magnitude" || std::find(derived.begin(), derived.end(), name) != derived.end();
    };
    if (textureName.empty() || isOutput(textureName)) {
        throw ParameterError(fmt::format("'{}' cannot be the texture's name", textureName));
    }
    for (const std::string& name : velocity.carry) {
        if (name != textureName && !isOutput(name)) continue;
        throw ParameterError(fmt::format("the grid '{}' to carry along has the name of an output; leave one of the two "
                                         "out, or give --texture-name another",
                                         name));
    }
}

int AdvectParams::prerollSteps() const
{
    return preroll.value_or(steady ? 0 : scatter.lifeSpan);
}

openvdb::MetaMap parameterMetadata(const AdvectParams& params)
{
    openvdb::MetaMap metadata;
    metadata.insertMeta("method", openvdb::StringMetadata(std::string(methodName(params))));
    if (params.steady) metadata.insertMeta("kernel", openvdb::StringMetadata(std::string(toString(*params.steady))));
    metadata.insertMeta("life_span", openvdb::Int32Metadata(params.scatter.lifeSpan));
    if (params.scatter.method == ScatterMethod::kAuflic && !params.steady) {
        metadata.insertMeta("release_window", openvdb::FloatMetadata(params.scatter.releaseWindow));
        metadata.insertMeta("history", openvdb::BoolMetadata(params.scatter.history));
    }
    metadata.insertMeta("sample_spacing", openvdb::FloatMetadata(params.scatter.pathline.sampleSpacing));
    metadata.insertMeta("tolerance", openvdb::FloatMetadata(params.scatter.pathline.tolerance));
    if (!params.steady) {
        metadata.insertMeta("sharpen", openvdb::FloatMetadata(params.feedback.sharpen));
        metadata.insertMeta("jitter", openvdb::StringMetadata(std::string(toString(params.feedback.jitter))));
        metadata.insertMeta("noise_share", openvdb::FloatMetadata(params.feedback.noiseShare));
        metadata.insertMeta("preroll", openvdb::Int32Metadata(params.prerollSteps()));
    }
    if (params.noise.empty()) {
        metadata.insertMeta("seed", openvdb::Int64Metadata(params.seed));
    } else {
        metadata.insertMeta("noise", openvdb::StringMetadata(params.noise));
    }
    return metadata;
}

ParameterTexts parameterTexts(const AdvectParams& params)
{
    const auto text = [](const auto& value) { return fmt::format("{}", value); };
    const auto& [method, life, window, history, pathline] = params.scatter;
    const auto& [sharpen, jitter, noiseShare, deviation] = params.feedback;
    const auto& [velocity, unit, scale, nonFinite, carry] = params.velocity;
    const auto& [mask, box, worldBox] = params.domain;
    const std::string noise =
        params.noise.empty() ? ""
                             : fmt::format("{} ({})", params.noise, fileStamp(parseGridReference(params.noise).path));
    return {
        {"--method", text(methodName(params))},
        {"--kernel", params.steady ? text(toString(*params.steady)) : ""},
        {"--life", text(life)},
        {"--velocity", velocity},
        {"--velocity-unit", unit ? text(toString(*unit)) : ""},
        {"--velocity-scale", text(scale)},
        {"--dt", textOf(params.frameSpacing)},
        {"--nonfinite", nonFinite == NonFinite::kZero ? "zero" : "refuse"},
        {"--carry", textOf(carry)},
        {"--with", textOf(params.derived)},
        {"--mask", mask},
        {"--bbox", textOf(box)},
        {"--bbox-world", textOf(worldBox)},
        {"--noise", noise},
        {"--seed", text(params.seed)},
        {"--preroll", text(params.prerollSteps())},
        {"--release-window", text(window)},
        {"--sample-spacing", text(pathline.sampleSpacing)},
        {"--tolerance", text(pathline.tolerance)},
        {"--sharpen", text(sharpen)},
        {"--jitter", text(toString(jitter))},
        {"--noise-share", text(noiseShare)},
        {"--texture-name", params.textureName},
        {"history", text(history)},
        {"deviation", text(deviation)},
    };
}

} // namespace vdblic
