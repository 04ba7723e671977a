#include "cli/look_options.h"

#include "vdblic/look/look_preset.h"
#include "vdblic/look/transfer_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace vdblic::cli {
namespace {

template<std::size_t N>
using Numbers = std::array<double, N>;

template<std::size_t N>
glm::dvec3 vector(const Numbers<N>& numbers, std::size_t first = 0)
{
    return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

} // namespace

LookOptions::LookOptions(CLI::App& app, RenderParams& params) : mApp(app), mParams(params)
{
    LookParams& look = params.look;
    TransferParams& transfer = look.transfer;
    Shading& shading = look.shading;
    ClipParams& clip = params.rays.clip;

    app.add_option("--look", mLook,
                   fmt::format("Look that all of the following start from: {}.", fmt::join(lookPresetNames(), ", ")))
        ->capture_default_str();
    option<std::string>("--by", "Float grid whose values choose colour and opacity; magnitude by default.",
                        [&](const auto& name) {
                            params.colorBy = name;
                            params.opacityBy.clear();
                        });
    option<std::string>("--color-by", "Float grid whose values choose the colour.",
                        [&](const auto& name) { params.colorBy = name; });
    option<std::string>("--opacity-by", "Float grid whose values choose the opacity.",
                        [&](const auto& name) { params.opacityBy = {name}; });
    option<std::string>("--transfer", "JSON file of a transfer function (docs/render-reference.md).",
                        [&](const auto& file) { readTransferFile(file, transfer); });
    option<std::string>("--colormap", fmt::format("Colours over the range: {}.", fmt::join(colorMapNames(), ", ")),
                        [&](const auto& name) {
                            transfer.colorMap = name;
                            transfer.colors.clear();
                        });
    option<std::string>("--colors",
                        "Colours of one's own over the range, e.g. 0:#102040,0.5:#e2581a,1:#fff6d5, as displayed.",
                        [&](const auto& text) { transfer.colors = parseColors(text); })
        ->type_name("POSITION:#RRGGBB,...")
        ->excludes("--colormap");
    option<std::string>("--opacity",
                        "Opacity of one voxel over the range, e.g. 0:0,0.4:0.05,1:0.8. By default it rises with the "
                        "values, scaled so that one sees into the volume.",
                        [&](const auto& text) { transfer.opacity = parseOpacity(text); })
        ->type_name("POSITION:OPACITY,...");
    option<Numbers<2>>("--range", "Values at positions 0 and 1 of the range; percentiles of the frames by default.",
                       [&](const auto& range) { transfer.range = range; })
        ->type_name("LO HI");
    option<Numbers<2>>("--opacity-range",
                       "The same of the grid that chooses the opacity; --range if colour follows the same grid.",
                       [&](const auto& range) { transfer.opacityRange = range; })
        ->type_name("LO HI");
    option<std::string>("--color-scale",
                        "linear or log: how the values of the range are spread over positions; linear by default.",
                        [&](const auto& name) { transfer.colorScale = parseValueScale(name); });
    option<std::string>("--opacity-scale",
                        "The same of the grid that chooses the opacity; linear by default, but --color-scale if one "
                        "grid with one range does both.",
                        [&](const auto& name) { transfer.opacityScale = parseValueScale(name); });
    number("--modulate", look.textureStrength, "How strongly the texture shows in opacity, 0 to 1.");
    number("--limb-darkening", look.limbDarkening,
           "How strongly the texture shows in colour: dark rims of streaks, 0 to 1.");

    option<std::string>("--shading",
                        "phong: by the texture's gradient; lines: as thin lines, by the direction the texture changes "
                        "least in; none.",
                        [&](const auto& name) { shading.model = shadingModel(name); });
    number("--ambient", shading.ambient, "Ambient reflection.");
    number("--diffuse", shading.diffuse, "Diffuse reflection.");
    number("--specular", shading.specular, "Specular reflection.");
    number("--shininess", shading.shininess, "Exponent of highlights.");
    number("--head-light", shading.headLight, "Intensity of the light at the eye.");
    option<std::vector<Numbers<3>>>(
        "--light", "Direction towards a far-away light [world], in place of the look's; may be repeated.",
        [&](const auto& lights) {
            shading.lights.clear();
            for (const auto& light : lights)
                shading.lights.push_back({vector(light)});
        })
        ->allow_extra_args(false)
        ->type_name("X Y Z");
    number("--halo", look.halo, "Strength of the gaps that streaks cut into what is behind them; 0: none.");
    number("--shadows", look.shadows, "How dark it is where the volume lets no light through, 0 to 1.");
    number("--depth-cue", look.depthCue, "How far the most distant samples fade into the background, 0 to 1.");

    option<std::vector<Numbers<6>>>(
        "--clip-plane",
        "Plane through a point, cutting away what its normal points away from [world]; may be repeated.",
        [&](const auto& planes) {
            for (const auto& plane : planes)
                clip.planes.push_back({vector(plane), vector(plane, 3)});
        })
        ->allow_extra_args(false)
        ->type_name("X Y Z NX NY NZ");
    option<Numbers<6>>("--clip-box", "Low and high corner of a box, cutting away what is outside [world].",
                       [&](const auto& box) {
                           clip.box = {vector(box), vector(box, 3)};
                       })
        ->type_name("X Y Z X Y Z");
    option<Numbers<3>>("--solid-color", "Colour of the solid as displayed, 0 to 1.", [&](const auto& color) {
        mParams.solid.color = vector(color);
    })->type_name("R G B");
    option<Numbers<3>>("--background", "Background as displayed, 0 to 1; the look's by default.",
                       [&](const auto& color) {
                           mParams.background = {vector(color), 1};
                       })
        ->type_name("R G B");
    number("--background-alpha", params.background.alpha,
           "How opaque the background is in .exr, 0 to 1; by default 1 if --background is given, else 0.");
}

void LookOptions::apply() const
{
    const LookPreset preset = lookPreset(mLook);
    mParams.look = preset.look;
    mParams.background = {preset.background, 0};
    mParams.opacityBy = preset.opacityBy;
    for (const auto& change : mChanges)
        change();
}

} // namespace vdblic::cli
