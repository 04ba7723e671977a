#include "cli/tool.h"
#include "vdblic/render/color_map.h"
#include "vdblic/render/render_sequence.h"

#include <fmt/ranges.h>

namespace {

using Numbers = std::vector<double>;

glm::dvec3 vector(const Numbers& numbers)
{
    return {numbers[0], numbers[1], numbers[2]};
}

/// An option of three numbers for a vector that is chosen automatically by default.
void vectorOption(CLI::App& app, const std::string& name, std::optional<glm::dvec3>& target, const std::string& help)
{
    app.add_option_function<Numbers>(
           name, [&target](const Numbers& numbers) { target = vector(numbers); }, help)
        ->expected(3)
        ->allow_extra_args(false)
        ->type_name("X Y Z");
}

} // namespace

int main(int argc, char** argv)
{
    vdblic::RenderParams params;
    vdblic::cli::Tool tool("vdblic_render", "Ray cast flow textures into images.");
    CLI::App& app = tool.app();
    tool.inputSequence("TEXTURE", params.input, "Texture volumes.");
    tool.skipExisting(params.skipExisting);
    tool.output(params.output, "Image or pattern of images, .exr (half float, linear) or .png (8 bit, opaque).");
    tool.option("--texture", params.texture, "Float grid that holds the texture.");
    app.add_option_function<std::vector<int>>(
           "--size",
           [&](const std::vector<int>& size) {
               params.size = {size[0], size[1]};
           },
           "Size of the image [pixels].")
        ->expected(2)
        ->allow_extra_args(false)
        ->type_name("W H")
        ->default_str(fmt::format("{} {}", params.size.x, params.size.y));

    vectorOption(app, "--eye", params.camera.eye,
                 "Place of the camera [world]. By default a three-quarter view that shows all of the first frame.");
    vectorOption(app, "--target", params.camera.target, "Place the camera looks at [world]; the middle by default.");
    vectorOption(app, "--up", params.camera.up, "Direction that is up in the image; 0 0 1 by default.");
    tool.option("--fov", params.camera.fieldOfView, "Vertical field of view [degrees].");

    tool.option("--step", params.rays.step, "Distance between samples [voxels]. Opacity does not depend on it.");
    tool.option("--colormap", params.look.transfer.colorMap,
                fmt::format("Colours of magnitude: {}.", fmt::join(vdblic::colorMapNames(), ", ")));
    std::string opacity;
    app.add_option("--opacity", opacity,
                   "Opacity of one voxel over the range of magnitudes, e.g. 0:0,0.4:0.05,1:0.8. By default it rises "
                   "with magnitude, scaled to the first frame so that one sees into the volume.")
        ->type_name("POSITION:OPACITY,...");
    app.add_option_function<Numbers>(
           "--range",
           [&](const Numbers& range) {
               params.look.transfer.range = {range[0], range[1]};
           },
           "Magnitudes at positions 0 and 1 [world/s]; percentiles of the first frame by default.")
        ->expected(2)
        ->allow_extra_args(false)
        ->type_name("LO HI");
    tool.option("--modulate", params.look.textureStrength,
                "How strongly the texture shows in colour and opacity, 0 to 1.");
    app.add_option_function<Numbers>(
           "--background",
           [&](const Numbers& numbers) {
               params.background = {vector(numbers), numbers.size() > 3 ? numbers[3] : 1};
           },
           "Background as displayed, 0 to 1; its alpha, 1 unless given, counts in .exr only. By default dark in .png "
           "and transparent in .exr.")
        ->expected(3, 4)
        ->allow_extra_args(false)
        ->type_name("R G B [A]");
    tool.verifies([&] { return std::vector<vdblic::SequenceParams>{params.input}; });
    return tool.run(argc, argv, [&](vdblic::Reporter& reporter) {
        if (!opacity.empty()) params.look.transfer.opacity = vdblic::parseOpacity(opacity);
        vdblic::renderSequence(params, tool.standardInput(), reporter);
    });
}
