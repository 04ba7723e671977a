#include "vdblic/render/render_sequence.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/domain_mask.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/render/color_map.h"

namespace vdblic {
namespace {

constexpr int kMostPixels = 32768; // a side

/// What stays the same for the whole animation, once a frame has shown what there is to see.
struct Scene {
    Look look;
    Camera camera;
};

TextureVolume readVolume(const RenderParams& params, const FrameFile& frame, bool& hasMagnitude)
{
    const VdbFile file = readVdb(frame.path);
    const auto find = [&](const std::string& name, const char* what, const char* option) {
        const auto grid = file.find<openvdb::FloatGrid>(name);
        if (!grid) {
            throw InputError(fmt::format("{}: no float grid '{}' {}; the file has {}; choose with {}",
                                         frame.path.string(), name, what, file.contents(), option));
        }
        return grid;
    };
    const auto texture = find(params.texture, "to render", "--texture");
    hasMagnitude = params.by != RenderParams{}.by || file.find<openvdb::FloatGrid>(params.by);
    const auto magnitude = hasMagnitude ? find(params.by, "to drive the transfer function", "--by") : texture;
    try {
        TextureVolume volume(*texture, *magnitude);
        if (!params.region.empty()) {
            volume.cut(*makeDomain(std::make_shared<openvdb::MaskTree>(volume.domain().topology()),
                                   texture->transform(), {.mask = params.region}, frame.frame));
        }
        if (params.look.shading.model == ShadingModel::kLine) volume.addLines();
        return volume;
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", frame.path.string(), error.what()));
    }
}

/// The camera and the look that show a volume well; nothing if it is empty.
std::optional<Scene> chooseScene(const RenderParams& params, const TextureVolume& volume,
                                 const std::filesystem::path& path)
{
    if (volume.empty()) return std::nullopt;
    try {
        Look look = chooseLook(params.look, volume);
        look.background = glm::vec3(linearFromDisplay(params.background.color));
        return Scene{std::move(look), Camera(params.camera, volume.corners(), params.size)};
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", path.string(), error.what()));
    }
}

ImageHeader imageHeader(const RenderParams& params, const Scene& scene, const FrameFile& file)
{
    const auto& [look, camera] = scene;
    ImageHeader header;
    header.worldToCamera = camera.worldToCamera();
    header.worldToNdc = camera.worldToNdc();
    header.screenWindowWidth = float(2 * camera.halfExtent().x);
    header.attributes = {
        {"frame", int(file.frame)},
        {"source", file.path.filename().string()},
        {"textureGrid", params.texture},
        {"eye", glm::vec3(camera.eye())},
        {"target", glm::vec3(camera.target())},
        {"up", glm::vec3(camera.up())},
        {"fieldOfView", float(camera.fieldOfView())},
        {"step", float(params.rays.step)},
        {"colorMap", look.transfer.colorMapName()},
        {"opacity", opacityText(look.transfer.opacity())},
        {"magnitudeRange", glm::vec2(look.transfer.range()[0], look.transfer.range()[1])},
        {"textureRange", glm::vec2(look.texture.low, look.texture.high)},
        {"textureStrength", look.texture.strength},
    };
    return header;
}

/// The scene as the first frame on disk gives it, whichever frames are selected.
std::optional<Scene> sceneOfSequence(const RenderParams& params)
{
    if (params.input.pattern == "-") return std::nullopt;
    SequenceParams all = params.input;
    if (const FramePattern pattern(all.pattern); pattern.hasField())
        all.frames = std::to_string(pattern.framesOnDisk().at(0));
    const FrameFile file = selectFrames(all).front();
    bool hasMagnitude = false;
    return chooseScene(params, readVolume(params, file, hasMagnitude), file.path);
}

void describe(const Scene& scene, Reporter& reporter)
{
    const auto& [look, camera] = scene;
    reporter.detail(fmt::format("eye {} {} {}, target {} {} {}", camera.eye().x, camera.eye().y, camera.eye().z,
                                camera.target().x, camera.target().y, camera.target().z));
    reporter.detail(fmt::format("magnitude {} to {}, opacity {}, texture {} to {}", look.transfer.range()[0],
                                look.transfer.range()[1], opacityText(look.transfer.opacity()), look.texture.low,
                                look.texture.high));
}

} // namespace

void RenderParams::validate() const
{
    (void)imageFormat(output);
    camera.validate();
    look.validate();
    rays.validate();
    background.validate();
    for (const int side : {size.x, size.y}) {
        if (side < 1 || side > kMostPixels) {
            throw ParameterError(
                fmt::format("image size {}x{} must be 1 to {} pixels a side", size.x, size.y, kMostPixels));
        }
    }
}

void renderSequence(const RenderParams& params, std::istream& lines, Reporter& reporter)
{
    params.validate();
    const FramePattern output(params.output);
    std::size_t total = 0, done = 0;
    const FrameSource source = openSequence(params.input, lines, total);
    if (total > 0) checkOutputPattern(output, total);

    std::optional<Scene> scene = sceneOfSequence(params);
    if (scene) describe(*scene, reporter);
    bool saidNoMagnitude = false;
    reporter.progress(0, total);
    while (const std::optional<FrameFile> file = source()) {
        if (done == 1) checkOutputPattern(output, 2); // paths from standard input: there is a second one
        const std::filesystem::path path = output.path(file->frame);
        if (params.skipExisting && isFinished(path)) {
            reporter.finished(path);
            reporter.progress(++done, total);
            continue;
        }
        bool hasMagnitude = false;
        const TextureVolume volume = readVolume(params, *file, hasMagnitude);
        if (!hasMagnitude && !saidNoMagnitude) {
            reporter.say(fmt::format("{}: no float grid 'magnitude'; the texture chooses colour and opacity instead",
                                     file->path.string()));
            saidNoMagnitude = true;
        }
        if (volume.unusableVoxels() > 0) {
            reporter.warn(fmt::format("{}: {} voxels are not finite numbers and are left out", file->path.string(),
                                      volume.unusableVoxels()));
        }
        if (!scene) {
            scene = chooseScene(params, volume, file->path);
            if (scene) describe(*scene, reporter);
        }

        Image image{params.size, std::vector<glm::vec4>(std::size_t(params.size.x) * params.size.y, glm::vec4(0))};
        ImageHeader header;
        if (scene) {
            image = castRays(volume, scene->look, scene->camera, params.rays);
            header = imageHeader(params, *scene, *file);
        }
        writeImage(path, image, header, params.background);
        reporter.finished(path);
        reporter.progress(++done, total);
    }
    if (done == 0) throw InputError("no frame to render: standard input named none");
}

} // namespace vdblic
