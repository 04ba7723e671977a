#include "picture.h"

#include "vdblic/io/texture_name.h"
#include "vdblic/look/look_preset.h"
#include "vdblic/look/transfer_file.h"
#include "vdblic/render/frame_picture.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace vdblic::python {
namespace {

using Triple = std::array<double, 3>;

glm::dvec3 vectorOf(const Triple& numbers)
{
    return {numbers[0], numbers[1], numbers[2]};
}

} // namespace

RenderParams renderParams(const Options& options)
{
    RenderParams params;
    const LookPreset preset = lookPreset(options.has("look") ? options.get<std::string>("look") : "flow");
    params.look = preset.look;
    params.background = {preset.background, 0};
    params.opacityBy = preset.opacityBy;
    TransferParams& transfer = params.look.transfer;
    if (options.has("by")) {
        options.set("by", params.colorBy);
        params.opacityBy.clear();
    }
    options.set("color_by", params.colorBy);
    if (options.has("opacity_by")) params.opacityBy = {options.get<std::string>("opacity_by")};
    if (options.has("transfer")) readTransferFile(options.get<std::string>("transfer"), transfer);
    if (options.has("colormap")) {
        options.set("colormap", transfer.colorMap);
        transfer.colors.clear();
    }
    if (options.has("colors")) transfer.colors = parseColors(options.get<std::string>("colors"));
    if (options.has("opacity")) transfer.opacity = parseOpacity(options.get<std::string>("opacity"));
    options.set("range", transfer.range);
    options.set("opacity_range", transfer.opacityRange);
    options.parse<ValueScale>("color_scale", transfer.colorScale, parseValueScale);
    if (options.has("opacity_scale"))
        transfer.opacityScale = parseValueScale(options.get<std::string>("opacity_scale"));
    options.set("shadows", params.look.shadows);
    options.set("texture", params.texture);
    options.set("solid", params.solid.source);
    if (options.has("size")) {
        const auto size = options.get<std::array<int, 2>>("size");
        params.size = {size[0], size[1]};
    }
    options.set("samples", params.samples);
    options.set("step", params.rays.step);
    if (options.has("stretch")) params.stretch = vectorOf(options.get<Triple>("stretch"));
    if (options.has("eye")) params.camera.eye = vectorOf(options.get<Triple>("eye"));
    if (options.has("target")) params.camera.target = vectorOf(options.get<Triple>("target"));
    if (options.has("up")) params.camera.up = vectorOf(options.get<Triple>("up"));
    options.parse<Projection>("projection", params.camera.projection, parseProjection);
    options.set("fov", params.camera.fieldOfView);
    options.set("view_height", params.camera.viewHeight);
    params.output = "picture.exr"; // which is not written
    params.input.pattern = "-";
    params.validate();
    return params;
}

Image Picture::of(const VdbFile& volume, std::int64_t frame)
{
    RenderParams params = mParams;
    params.texture = textureName(volume.metadata, mParams.texture);
    const auto loaded = std::make_shared<const LoadedTexture>(loadFrame(params, volume, {frame, volume.path}));
    if (!mScene) {
        const glm::ivec2 size = params.scaledSize();
        if (loaded->volume.empty()) return {size, std::vector<glm::vec4>(std::size_t(size.x) * size.y, glm::vec4(0))};
        mScene = chooseScene(params, {&loaded, 1}, loaded->volume.corners(), true, {});
        if (!mParams.opacityBy.empty()) mParams.opacityBy = {mScene->opacityBy};
    }
    std::shared_ptr<const Solid> solid;
    if (!params.solid.source.empty())
        solid = std::make_shared<const Solid>(makeSolid(params.solid, *loaded->texture, params.stretch, frame));
    FramePicture picture(params, *mScene, *loaded, std::move(solid));
    for (int sample = 0; sample < params.samples; ++sample)
        picture.addSample();
    return picture.image();
}

} // namespace vdblic::python
