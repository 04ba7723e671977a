#include "vdblic/render/ray_caster.h"

#include "vdblic/core/errors.h"
#include "vdblic/render/ray_kernel.h"
#include "vdblic/render/ray_setup.h"

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

#include <array>

namespace vdblic {
namespace {

/// The part of a ray's alpha whose colour was found.
float shaded(const RaySum& sum)
{
    return sum.alpha - sum.halo - sum.waiting;
}

PixelLayers layersOf(const RaySum& sum, const RayTask& task)
{
    PixelLayers layers;
    layers.samples = float(sum.samples);
    if (!(sum.alpha > 0)) return layers;
    const float haloDepth = task.shading[kEntryDepth] * sum.halo + task.shading[kDepthPerStep] * sum.haloPlace;
    layers.depth = (sum.numbers[0] + haloDepth) / (shaded(sum) + sum.halo);
    const float weight = shaded(sum); // a halo has a place, but nothing else
    if (!(weight > 0)) return layers;
    layers.magnitude = sum.numbers[1] / weight;
    layers.texture = sum.numbers[2] / weight;
    const glm::vec3 normal(sum.normal[0], sum.normal[1], sum.normal[2]);
    if (const float length = glm::length(normal); length > 0) layers.normal = normal / length;
    return layers;
}

std::vector<std::uint8_t> findVisible(const TextureVolume& volume, const Look& look)
{
    std::vector<std::uint8_t> visible(volume.domain().leafCount());
    for (std::size_t leaf = 0; leaf < visible.size(); ++leaf)
        visible[leaf] = !volume.shown(leaf).isOff() && look.contributes(volume.leafRange(leaf));
    return visible;
}

} // namespace

void RayCastParams::validate() const
{
    if (!(step >= 0.01 && step <= 100)) {
        throw ParameterError(fmt::format("step {} must be between 0.01 and 100 voxels", step));
    }
    if (!(leastTransmittance >= 0 && leastTransmittance < 1)) {
        throw ParameterError(fmt::format("least transmittance {} must be at least 0 and below 1", leastTransmittance));
    }
    clip.validate();
}

VisibleLeaves::VisibleLeaves(const TextureVolume& volume, const std::vector<std::uint8_t>& visible)
    : mLeaves(LeafBlock::kCount, kNothing)
{
    const Domain& domain = volume.domain();
    openvdb::CoordBBox box;
    for (std::size_t leaf = 0; leaf < visible.size(); ++leaf)
        box.expand(domain.origin(leaf));
    if (box.empty()) return;
    mFirst = box.min().offsetBy(-LeafVoxel::kDim);
    for (int axis = 0; axis < 3; ++axis)
        mDim[axis] = (box.max()[axis] - mFirst[axis]) / kBlockDim + 1;
    mBlocks.assign(std::size_t(mDim[0]) * mDim[1] * mDim[2], kNoBlock);
    for (std::size_t leaf = 0; leaf < visible.size(); ++leaf) {
        if (!visible[leaf]) continue;
        const openvdb::Coord voxel = domain.origin(leaf) - mFirst;
        int& block = mBlocks[blockPlace(voxel[0] / kBlockDim, voxel[1] / kBlockDim, voxel[2] / kBlockDim)];
        if (block == kNoBlock) {
            block = int(mLeaves.size());
            mLeaves.resize(mLeaves.size() + LeafBlock::kCount, kNothing);
        }
        mLeaves[std::size_t(block + LeafBlock::leafIndex(voxel[0], voxel[1], voxel[2]))] =
            entryOf(leaf, voxel) | (volume.shown(leaf).isOn() ? 0 : kPartly);
    }
}

unsigned VisibleLeaves::entryOf(std::size_t leaf, const openvdb::Coord& origin)
{
    static_assert(kBrickSize % (kFlags + 1) == 0 && brickIndex(0, 0, 0) % (kFlags + 1) == kFlags);
    const auto record = unsigned(leaf * kBrickSize) + brickIndex(0, 0, 0);
    return record - kFlags - recordSteps(unsigned(origin[0]), unsigned(origin[1]), unsigned(origin[2]));
}

VisibleLeaves::VisibleLeaves(const TextureVolume& volume, const Look& look)
    : VisibleLeaves(volume, findVisible(volume, look))
{
}

float sampleShift(int x, int y, int ray)
{
    // The inverse powers of the plastic number, and the radical inverse, as fractions of 2³².
    std::uint32_t place = std::uint32_t(x) * 3242174889u + std::uint32_t(y) * 2447445414u;
    for (int bit = 31; ray != 0; ray >>= 1, --bit)
        place += std::uint32_t(ray & 1) << bit;
    return float(int(place >> 8)) * 0x1p-24f;
}

Image castRays(const TextureVolume& volume, const Look& look, const Camera& camera, const RayCastParams& params,
               const VisibleLeaves& visible, int ray)
{
    params.validate();
    const glm::ivec2 size = camera.size();
    Image image{size, std::vector<glm::vec4>(std::size_t(size.x) * size.y, glm::vec4(0))};
    if (params.layers) image.layers.resize(image.pixels.size());
    const SampleShader shader(volume, look, camera, params);
    const RaySetup setup(volume, visible, camera, params, shader, ray);
    const RayKernel kernel(volume, look, params, visible, shader);
    constexpr int kTile = RaySetup::kTile;
    const int tilesX = (size.x + kTile - 1) / kTile, tilesY = (size.y + kTile - 1) / kTile;
    tbb::parallel_for(0, tilesX * tilesY, [&](int tile) {
        std::array<RayTask, kTile * kTile> tasks;
        const int count = setup.rays(tile % tilesX * kTile, tile / tilesX * kTile, tasks.data());
        std::array<RaySum, kTile * kTile> sums{};
        kernel.trace(tasks.data(), count, sums.data());
        for (std::size_t i = 0; i < std::size_t(count); ++i) {
            const RaySum& sum = sums[i];
            // What was not shaded takes on the colour of what was.
            const float part = shaded(sum), whole = part > 0 ? (sum.alpha - sum.halo) / part : 0;
            const glm::vec3 color = glm::vec3(sum.color[0], sum.color[1], sum.color[2]) * whole;
            const auto pixel = std::size_t(tasks[i].pixel);
            image.pixels[pixel] = glm::vec4(color + look.background * sum.halo, sum.alpha);
            if (params.layers) image.layers[pixel] = layersOf(sum, tasks[i]);
        }
    });
    return image;
}

Image castRays(const TextureVolume& volume, const Look& look, const Camera& camera, const RayCastParams& params)
{
    return castRays(volume, look, camera, params, VisibleLeaves(volume, look));
}

} // namespace vdblic
