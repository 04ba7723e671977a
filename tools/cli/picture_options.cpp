#include "cli/picture_options.h"

#include <fmt/format.h>
#include <glm/vec3.hpp>

#include <array>
#include <string>
#include <vector>

namespace vdblic::cli {
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

PictureOptions::PictureOptions(CLI::App& app, RenderParams& params)
    : mParams(params), mProjection(toString(params.camera.projection)), mLook(app, params)
{
    app.add_option("--texture", params.texture,
                   "Float grid that holds the texture; by default the one that vdblic_advect made, else density.");
    app.add_option_function<std::vector<int>>(
           "--size",
           [&params](const std::vector<int>& size) {
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
    app.add_option("--scale", params.scale, "Factor on the size, for previews.")->capture_default_str();
    app.add_option("--samples", params.samples, "Rays to a pixel, at points of a low-discrepancy pattern.")
        ->capture_default_str();

    vectorOption(app, "--eye", params.camera.eye,
                 "Position of the camera [world]. By default a three-quarter view that shows all of every frame.");
    vectorOption(app, "--target", params.camera.target, "Position the camera looks at [world]; the middle by default.");
    vectorOption(app, "--up", params.camera.up, "Direction that is up in the image; 0 0 1 by default.");
    app.add_option("--projection", mProjection, "perspective or orthographic.")->capture_default_str();
    app.add_option("--fov", params.camera.fieldOfView, "Vertical field of view of a perspective [degrees].")
        ->capture_default_str();
    app.add_option("--view-height", params.camera.viewHeight,
                   "Height of an orthographic picture [world]; by default all is seen.");
    app.add_option("--orbit", params.motion.orbit,
                   "Turns of the camera around the target in the course of the sequence; the last frame ends one step "
                   "before the first begins again.");
    app.add_option("--orbit-frames", params.motion.orbitFrames,
                   "Frames that the turns take, instead of those on disk; needed for paths on standard input, where "
                   "frame 1 is the first.");
    app.add_option("--camera", mKeys, "JSON file of key frames of the camera (docs/render-reference.md).");

    app.add_option("--step", params.rays.step, "Distance between samples [voxels]. Opacity does not depend on it.")
        ->capture_default_str();
    app.add_option("--roi", params.region, "FILE or FILE:GRID whose active voxels are all that is shown.");
    app.add_option("--roi-box", params.regionBox,
                   "Low and high corner of a box; only voxels with their centre inside are shown [world].")
        ->type_name("X Y Z X Y Z");
    app.add_option(
        "--solid", params.solid.source,
        "Opaque body: FILE or FILE:GRID, a closed mesh (.obj, .stl, .ply), level set, fog volume or mask, one "
        "file or a sequence; or domain, what the texture leaves out of its box.");
    app.add_option(
           "--annotate", mAnnotations,
           "Explanations over the picture: box, axes, colorbar, time, title=TEXT; NAME,NAME. In .exr channels of "
           "their own, annotation.R and so on.")
        ->type_name("NAME");
}

void PictureOptions::apply() const
{
    mLook.apply();
    mParams.camera.projection = parseProjection(mProjection);
    if (!mKeys.empty()) mParams.motion.keys = readCameraKeys(mKeys);
    if (!mAnnotations.empty()) mParams.annotations = parseAnnotations(mAnnotations);
}

} // namespace vdblic::cli
