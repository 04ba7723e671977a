#include "cli/look_options.h"
#include "vdblic/render/render_sequence.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/vec3.hpp>

#include <array>
#include <string>
#include <vector>

namespace {

/// An option of three numbers. @param target a vector or an optional one
template<typename Vector>
void vectorOption(CLI::App& app, const std::string& name, Vector& target, const std::string& help)
{
    using Numbers = std::array<double, 3>;
    app.add_option_function<Numbers>(
           name, [&target](const Numbers& n) { target = glm::dvec3(n[0], n[1], n[2]); }, help)
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
    app.add_flag("--keep-going", params.keepGoing,
                 "Leave out frames that cannot be read; the exit status tells at the end.");
    app.add_option(
        "-o,--output", params.output,
        "Image or pattern of images, .exr (linear, premultiplied alpha) or .png (8 bit sRGB, opaque). May be "
        "left out with --histogram or --transfer-out.");
    app.add_option("--texture", params.texture,
                   "Float grid that holds the texture; by default the one that vdblic_advect made, else density.");
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
    vectorOption(app, "--stretch", params.stretch,
                 "Factors on the world's axes, such as 1 1 20 to exaggerate heights; camera and lights stand in the "
                 "stretched space, cuts in the data's own.");
    tool.option("--scale", params.scale, "Factor on the size, for previews.");
    tool.option("--samples", params.samples, "Rays to a pixel, at points of a low-discrepancy pattern.");

    vectorOption(app, "--eye", params.camera.eye,
                 "Position of the camera [world]. By default a three-quarter view that shows all of every frame.");
    vectorOption(app, "--target", params.camera.target, "Position the camera looks at [world]; the middle by default.");
    vectorOption(app, "--up", params.camera.up, "Direction that is up in the image; 0 0 1 by default.");
    std::string projection(toString(params.camera.projection));
    tool.option("--projection", projection, "perspective or orthographic.");
    tool.option("--fov", params.camera.fieldOfView, "Vertical field of view of a perspective [degrees].");
    app.add_option("--view-height", params.camera.viewHeight,
                   "Height of an orthographic picture [world]; by default all is seen.");
    app.add_option("--orbit", params.motion.orbit,
                   "Turns of the camera around the target in the course of the sequence; the last frame ends one step "
                   "before the first begins again.");
    app.add_option("--orbit-frames", params.motion.orbitFrames,
                   "Frames that the turns take, instead of those on disk; needed for paths on standard input, where "
                   "frame 1 is the first.");
    app.add_option("--camera", params.motion.keys, "JSON file of key frames of the camera (docs/render.md).");

    tool.option("--step", params.rays.step, "Distance between samples [voxels]. Opacity does not depend on it.");
    const vdblic::cli::LookOptions look(tool, params);
    app.add_option("--roi", params.region, "FILE or FILE:GRID whose active voxels are all that is shown.");
    app.add_option(
        "--solid", params.solid.source,
        "Opaque body: FILE or FILE:GRID, a closed mesh (.obj, .stl, .ply), level set, fog volume or mask, one "
        "file or a sequence; or domain, what the texture leaves out of its box.");
    std::vector<std::string> layers;
    app.add_option("--aov", layers,
                   "Further channels of .exr: depth, normal, magnitude, texture, samples, or all; NAME,NAME.")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name("NAME");
    tool.option("--precision", params.exr.precision, "Of colour and alpha in .exr: half or float.");
    tool.option("--compression", params.exr.compression,
                fmt::format("Of .exr: {}.", fmt::join(vdblic::exrCompressions(), ", ")));
    app.add_option("--histogram", params.histogram,
                   "Histograms of texture and scalars with the transfer function over them, .png or .json.");
    app.add_option("--transfer-out", params.transferOut,
                   "JSON file for the range, colours and opacity that are rendered with, for --transfer.");
    std::string annotations;
    app.add_option(
           "--annotate", annotations,
           "Explanations over the picture: box, axes, colorbar, time, title=TEXT; NAME,NAME. In .exr channels of "
           "their own, annotation.R and so on.")
        ->type_name("NAME");
    app.add_option("--film", params.film, "Film of all frames, .mp4, made by ffmpeg; -o may be left out.");
    tool.option("--fps", params.framesPerSecond, "Frames of the film a second.");
    tool.verifies([&] { return std::vector<vdblic::SequenceParams>{params.input}; });
    return tool.run(argc, argv, [&](vdblic::Reporter& reporter) {
        look.apply();
        if (!annotations.empty()) params.annotations = vdblic::parseAnnotations(annotations);
        params.camera.projection = vdblic::parseProjection(projection);
        params.exr.layers = vdblic::parseImageLayers(layers);
        params.rays.layers = !params.exr.layers.empty();
        vdblic::renderSequence(params, tool.standardInput(), reporter);
    });
}
