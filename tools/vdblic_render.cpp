#include "cli/look_options.h"
#include "vdblic/render/render_sequence.h"

#include <fmt/format.h>

#include <iostream>

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
    const vdblic::cli::LookOptions look(tool);
    tool.option("--by", params.by, "Float grid that drives the transfer function.");
    app.add_option("--roi", params.region, "FILE or FILE:GRID whose active voxels are all that is shown.");
    return tool.run(argc, argv, [&](vdblic::Reporter& reporter) {
        look.apply(params);
        vdblic::renderSequence(params, std::cin, reporter);
    });
}
