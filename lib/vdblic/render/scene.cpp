#include "vdblic/render/scene.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/domain_mask.h"
#include "vdblic/field/resample.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/render/color_map.h"
#include "vdblic/render/render_params.h"
#include "vdblic/render/sequence_bounds.h"

#include <fmt/format.h>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

double memoryOf(const RenderParams& params, const TextureVolume& volume)
{
    constexpr double kGridLeaf =
        2 * (sizeof(openvdb::FloatTree::LeafNodeType::Buffer) + LeafVoxel::kCount * sizeof(float));
    const double record =
        double(sizeof(ValueRecord) + sizeof(GradientRecord)) + (volume.lines() ? sizeof(LineRecord) : 0);
    return double(volume.domain().leafCount()) * (kGridLeaf + kPaddedSize * record) + params.imageBytes();
}

} // namespace

LoadedTexture loadFrame(const RenderParams& params, const FrameFile& frame)
{
    const VdbFile file = readVdb(frame.path);
    const auto texture = file.get<openvdb::FloatGrid>(params.texture, "`texture`");
    const bool hasDriver = params.driver != RenderParams{}.driver || file.find<openvdb::FloatGrid>(params.driver);
    const auto stored = hasDriver ? file.get<openvdb::FloatGrid>(params.driver, "`driver`") : texture;
    try {
        const bool together = stored->transform() == texture->transform() || !stored->transform().isLinear();
        const auto driver = together ? stored : resampled(*stored, *texture);
        LoadedTexture loaded{frame, texture, driver, hasDriver, TextureVolume(*texture, *driver, params.stretch)};
        if (!params.region.empty()) {
            const auto topology = std::make_shared<openvdb::MaskTree>(loaded.volume.domain().topology());
            loaded.volume.cut(
                *makeDomain(topology, texture->transform(), {.mask = params.region}, frame.frame).texture);
        }
        if (params.look.shading.model == ShadingModel::kLine) loaded.volume.addLines();
        return loaded;
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", frame.path.string(), error.what()));
    }
}

Scene chooseScene(const RenderParams& params, std::span<const LoadedTexture> frames, const Corners& box,
                  const FrameSpan& span)
{
    const CameraPath cameras(params.camera, params.motion, box, params.scaledSize(), span);
    TextureVolume::Samples samples;
    double voxels = 0, bytes = 0;
    for (const LoadedTexture& frame : frames) {
        const TextureVolume::Samples more = frame.volume.samples();
        samples.texture.insert(samples.texture.end(), more.texture.begin(), more.texture.end());
        samples.driver.insert(samples.driver.end(), more.driver.begin(), more.driver.end());
        voxels = std::max(voxels, double(frame.volume.domain().voxelCount()));
        bytes = std::max(bytes, memoryOf(params, frame.volume));
    }
    try {
        Look look = chooseLook(params.look, samples, std::cbrt(voxels));
        look.background = glm::vec3(linearFromDisplay(params.background.color));
        return {std::move(look), cameras, bytes};
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", frames.front().file.path.string(), error.what()));
    }
}

std::optional<SequenceScene> sceneOfSequence(const RenderParams& params)
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
    std::optional<SequenceBounds> bounds = sequenceBounds(files, params.texture);
    if (!bounds) return std::nullopt;
    for (glm::dvec3& corner : bounds->box)
        corner *= params.stretch;
    // The look is made from a few frames of the whole sequence. A file that cannot be read is reported at its turn.
    constexpr std::size_t kLookFrames = 4;
    std::vector<LoadedTexture> frames;
    try {
        frames.push_back(loadFrame(params, bounds->firstFilled));
    } catch (const InputError&) {
        if (!params.keepGoing) throw;
    }
    for (std::size_t i = 1; i < std::min(kLookFrames, files.size()); ++i) {
        const FrameFile& file = files[i * (files.size() - 1) / (std::min(kLookFrames, files.size()) - 1)];
        if (file.frame == bounds->firstFilled.frame) continue;
        try {
            frames.push_back(loadFrame(params, file));
        } catch (const InputError&) {
            continue;
        }
    }
    std::erase_if(frames, [](const LoadedTexture& frame) { return frame.volume.empty(); });
    if (frames.empty()) return std::nullopt;
    SequenceScene result{chooseScene(params, frames, bounds->box, span), nullptr};
    if (files.size() == 1) result.onlyFrame = std::make_shared<const LoadedTexture>(std::move(frames.front()));
    return result;
}

} // namespace vdblic
