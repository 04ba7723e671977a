#include "vdblic/render/scene.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/render/sequence_bounds.h"

namespace vdblic {
namespace {

double memoryOf(const RenderParams& params, const TextureVolume& volume)
{
    constexpr double kGridLeaf = 2 * sizeof(openvdb::FloatTree::LeafNodeType::Buffer) + 2 * 512 * sizeof(float);
    const double pixels = double(params.scaledSize().x) * params.scaledSize().y;
    const double perPixel = sizeof(glm::vec4) * 3 + (params.rays.layers ? 2 * sizeof(PixelLayers) : 0);
    return double(volume.domain().leafCount()) * (kGridLeaf + Bricks::kSize * sizeof(Record)) + pixels * perPixel;
}

} // namespace

LoadedTexture loadFrame(const RenderParams& params, const FrameFile& frame)
{
    const VdbFile file = readVdb(frame.path);
    const auto texture = file.find<openvdb::FloatGrid>(params.texture);
    if (!texture) {
        throw InputError(fmt::format("{}: no float grid '{}' to render; the file has {}; choose with --texture",
                                     frame.path.string(), params.texture, file.contents()));
    }
    const auto magnitude = file.find<openvdb::FloatGrid>("magnitude");
    const auto& driving = magnitude ? magnitude : texture;
    try {
        return {frame, texture, driving, magnitude != nullptr, TextureVolume(*texture, *driving)};
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", frame.path.string(), error.what()));
    }
}

Scene chooseScene(const RenderParams& params, const LoadedTexture& frame, const Corners& box, const FrameSpan& span)
{
    const CameraPath cameras(params.camera, params.motion, box, params.scaledSize(), span);
    try {
        return {chooseLook(params.look, frame.volume), cameras, memoryOf(params, frame.volume)};
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", frame.file.path.string(), error.what()));
    }
}

std::optional<Scene> sceneOfSequence(const RenderParams& params)
{
    const FramePattern pattern(params.input.pattern);
    std::vector<FrameFile> files;
    FrameSpan span;
    if (pattern.hasField()) {
        for (const std::int64_t frame : pattern.framesOnDisk())
            files.push_back({frame, pattern.path(frame)});
        span.first = files.front().frame;
        span.length = files.back().frame - files.front().frame + frameSpacing(params.input);
    } else {
        files = selectFrames(params.input);
    }
    const std::optional<SequenceBounds> bounds = sequenceBounds(files, params.texture);
    if (!bounds) return std::nullopt;
    const LoadedTexture frame = loadFrame(params, bounds->firstFilled);
    if (frame.volume.empty()) return std::nullopt;
    return chooseScene(params, frame, bounds->box, span);
}

} // namespace vdblic
