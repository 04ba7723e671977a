#include "vdblic/run/parameter_texts.h"

#include "vdblic/io/file_stamp.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/run/advect_params.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cstddef>
#include <optional>

namespace vdblic {
namespace {

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

ParameterTexts parameterTexts(const AdvectParams& params)
{
    const auto text = [](const auto& value) { return fmt::format("{}", value); };
    const auto& [method, life, substeps, window, pathline, feedback] = params.texture;
    const auto& [taps, sharpen, noiseShare, deviation] = feedback;
    const auto& [velocity, unit, scale, nonFinite, carry] = params.flow.velocity;
    const auto& [mask, box, worldBox, refinement] = params.flow.domain;
    const std::string noise =
        params.noise.empty() ? ""
                             : fmt::format("{} ({})", params.noise, fileStamp(parseGridReference(params.noise).path));
    return {
        {"method", text(nameOf(method))},
        {"life_span", text(life)},
        {"substeps", text(substeps)},
        {"velocity", velocity},
        {"velocity_unit", unit ? text(toString(*unit)) : ""},
        {"velocity_scale", text(scale)},
        {"dt", textOf(params.flow.frameSpacing)},
        {"non_finite", nonFinite == NonFinite::kZero ? "zero" : "refuse"},
        {"carry", textOf(carry)},
        {"derived", textOf(params.derived)},
        {"mask", mask},
        {"box", textOf(box)},
        {"world_box", textOf(worldBox)},
        {"refine", fmt::format("{}", fmt::join(refinement.factors, " "))},
        {"interpolation", text(toString(refinement.interpolation))},
        {"noise", noise},
        {"seed", text(params.seed)},
        {"preroll", text(params.prerollFrames())},
        {"lead_in", text(params.leadInFrames())},
        {"release_window", text(window)},
        {"sample_spacing", text(pathline.sampleSpacing)},
        {"tolerance", text(pathline.tolerance)},
        {"sharpen", text(sharpen)},
        {"noise_share", text(noiseShare)},
        {"finish", text(params.finishTaps())},
        {"texture_name", params.textureName},
        {"precision", text(toString(params.format.precision))},
        {"compression", text(toString(params.format.compression))},
        {"scalars", text(toString(params.format.scalars))},
        {"mean_along_flow", text(taps)},
        {"deviation", text(deviation)},
    };
}

} // namespace vdblic
