#include "cli/look_options.h"

#include "vdblic/render/transfer_file.h"

#include <fmt/ranges.h>

namespace vdblic::cli {
namespace {

template<std::size_t N>
glm::dvec3 vector(const std::array<double, N>& numbers, std::size_t first = 0)
{
    return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

} // namespace

LookOptions::LookOptions(Tool& tool)
{
    CLI::App& app = tool.app();
    tool.option("--look", mLook,
                fmt::format("Look that all of the following start from: {}.", fmt::join(lookPresetNames(), ", ")));
    app.add_option("--transfer", mTransfer, "JSON file of a transfer function (docs/render.md).");
    app.add_option("--colormap", mColorMap, fmt::format("Colours of magnitude: {}.", fmt::join(colorMapNames(), ", ")));
    app.add_option("--opacity", mOpacity,
                   "Opacity of one voxel over the range of magnitudes, e.g. 0:0,0.4:0.05,1:0.8. By default it rises "
                   "with magnitude, scaled so that one sees into the volume.")
        ->type_name("POSITION:OPACITY,...");
    app.add_option("--range", mRange,
                   "Magnitudes at positions 0 and 1 [world/s]; percentiles of the frames by default.")
        ->type_name("LO HI");
    app.add_option("--modulate", mModulate, "How strongly the texture shows in opacity, 0 to 1.");
    app.add_option("--limb-darkening", mLimb,
                   "How strongly the texture shows in colour: dark rims of streaks, 0 to 1.");

    app.add_option("--shading", mShading,
                   "phong: by the texture's gradient; lines: as thin lines, by the direction the texture changes least "
                   "in; none.");
    app.add_option("--ambient", mAmbient, "Ambient reflection.");
    app.add_option("--diffuse", mDiffuse, "Diffuse reflection.");
    app.add_option("--specular", mSpecular, "Specular reflection.");
    app.add_option("--shininess", mShininess, "Exponent of highlights.");
    app.add_option("--head-light", mHeadLight, "Intensity of the light at the eye.");
    app.add_option("--light", mLights,
                   "Direction towards a far-away light [world], in place of the look's; may be repeated.")
        ->allow_extra_args(false)
        ->type_name("X Y Z");
    app.add_option("--halo", mHalo, "Strength of the gaps that streaks cut into what is behind them; 0: none.");
    app.add_option("--depth-cue", mDepthCue, "How far the most distant samples fade into the background, 0 to 1.");

    app.add_option("--clip-plane", mClipPlanes,
                   "Plane through a point, cutting away what its normal points away from [world]; may be repeated.")
        ->allow_extra_args(false)
        ->type_name("X Y Z NX NY NZ");
    app.add_option("--clip-box", mClipBox, "Low and high corner of a box, cutting away what is outside [world].")
        ->type_name("X Y Z X Y Z");
    app.add_option("--background", mBackground, "Background as displayed, 0 to 1; the look's by default.")
        ->type_name("R G B");
    app.add_option("--background-alpha", mBackgroundAlpha,
                   "How opaque the background is in .exr, 0 to 1; by default 1 if --background is given, else 0.");
}

void LookOptions::apply(RenderParams& params) const
{
    const LookPreset preset = lookPreset(mLook);
    params.look = preset.look;
    params.background = {preset.background, 0};
    if (mBackground) params.background = {vector(*mBackground), 1};
    if (mBackgroundAlpha) params.background.alpha = *mBackgroundAlpha;
    ClipParams& clip = params.rays.clip;
    for (const auto& plane : mClipPlanes)
        clip.planes.push_back({vector(plane), vector(plane, 3)});
    if (mClipBox) clip.box = {vector(*mClipBox), vector(*mClipBox, 3)};

    TransferParams& transfer = params.look.transfer;
    if (mTransfer) readTransferFile(*mTransfer, transfer);
    if (mColorMap) {
        transfer.colorMap = *mColorMap;
        transfer.colors.clear();
    }
    if (mOpacity) transfer.opacity = parseOpacity(*mOpacity);
    if (mRange) transfer.range = mRange;

    const auto set = [](const auto& given, auto& target) {
        if (given) target = *given;
    };
    set(mModulate, params.look.textureStrength);
    set(mLimb, params.look.limbDarkening);
    set(mHalo, params.look.halo);
    set(mDepthCue, params.look.depthCue);
    Shading& shading = params.look.shading;
    if (mShading) shading.model = shadingModel(*mShading);
    set(mAmbient, shading.ambient);
    set(mDiffuse, shading.diffuse);
    set(mSpecular, shading.specular);
    set(mShininess, shading.shininess);
    set(mHeadLight, shading.headLight);
    if (!mLights.empty()) shading.lights.clear();
    for (const auto& light : mLights)
        shading.lights.push_back({vector(light)});
}

} // namespace vdblic::cli
