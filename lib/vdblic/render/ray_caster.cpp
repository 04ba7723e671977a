#include "vdblic/render/ray_caster.h"

#include "vdblic/core/errors.h"
#include "vdblic/render/ray_kernel.h"

#include <tbb/parallel_for.h>

#include <cmath>

namespace vdblic {
namespace {

constexpr int kTile = 16; // pixels a side

/// Where the ray of a pixel meets the active voxels' bounds, in index space.
RayTask prepareRay(const TextureVolume& volume, const Camera& camera, double step, int x, int y)
{
    const Ray ray = camera.ray({x + 0.5, y + 0.5});
    const glm::dvec3 origin(volume.worldToIndex() * glm::dvec4(ray.origin, 1));
    const glm::dvec3 perWorld = glm::dmat3(volume.worldToIndex()) * ray.direction;
    const double voxelsPerWorld = glm::length(perWorld);
    const glm::dvec3 direction = perWorld / voxelsPerWorld;

    double enter = 0, leave = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const double first = (volume.low()[axis] - origin[axis]) / direction[axis];
        const double second = (volume.high()[axis] - origin[axis]) / direction[axis];
        // On a face of a box it is parallel to, a ray gives 0/0, which these comparisons ignore.
        if (std::min(first, second) > enter) enter = std::min(first, second);
        if (std::max(first, second) < leave) leave = std::max(first, second);
        const bool beside = origin[axis] < volume.low()[axis] || origin[axis] > volume.high()[axis];
        if (direction[axis] == 0 && beside) leave = -1;
    }
    RayTask task{};
    task.pixel = y * camera.size().x + x;
    task.shift = sampleShift(x, y);
    task.samples = leave > enter ? int((leave - enter) / step) + 1 : 0;
    const double depthPerWorld = (camera.worldToCamera() * glm::dvec4(ray.direction, 0)).z;
    task.depthPerVoxel = float(depthPerWorld / voxelsPerWorld);
    task.entryDepth = float(enter * depthPerWorld / voxelsPerWorld);
    for (int axis = 0; axis < 3; ++axis) {
        task.entry[axis] = float(origin[axis] + direction[axis] * enter);
        task.direction[axis] = float(direction[axis]);
        task.view[axis] = float(ray.direction[axis]);
    }
    return task;
}

std::vector<std::uint8_t> findVisible(const TextureVolume& volume, const Look& look)
{
    std::vector<std::uint8_t> visible(volume.domain().leafCount());
    for (std::size_t leaf = 0; leaf < visible.size(); ++leaf)
        visible[leaf] = look.contributes(volume.leafRange(leaf));
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
}

VisibleLeaves::VisibleLeaves(const Domain& domain, std::vector<std::uint8_t> visible) : mLeaves(std::move(visible))
{
    openvdb::CoordBBox box;
    for (std::size_t leaf = 0; leaf < mLeaves.size(); ++leaf) {
        if (mLeaves[leaf]) box.expand(domain.origin(leaf));
    }
    if (box.empty()) return;
    for (int axis = 0; axis < 3; ++axis) {
        mFirst[axis] = box.min()[axis] >> kBlockShift;
        mDim[axis] = unsigned((box.max()[axis] >> kBlockShift) - mFirst[axis] + 1);
    }
    mBlocks.assign(std::size_t(mDim[0]) * mDim[1] * mDim[2], 0);
    for (std::size_t leaf = 0; leaf < mLeaves.size(); ++leaf) {
        if (!mLeaves[leaf]) continue;
        const openvdb::Coord c = domain.origin(leaf);
        mBlocks[(std::size_t((c[0] >> kBlockShift) - mFirst[0]) * mDim[1] +
                 std::size_t((c[1] >> kBlockShift) - mFirst[1])) *
                    mDim[2] +
                std::size_t((c[2] >> kBlockShift) - mFirst[2])] = 1;
    }
}

VisibleLeaves::VisibleLeaves(const TextureVolume& volume, const Look& look)
    : VisibleLeaves(volume.domain(), findVisible(volume, look))
{
}

float sampleShift(int x, int y)
{
    // The inverse powers of the plastic number as fractions of 2³².
    const std::uint32_t place = std::uint32_t(x) * 3242174889u + std::uint32_t(y) * 2447445414u;
    return float(place >> 8) * 0x1p-24f;
}

Image castRays(const TextureVolume& volume, const Look& look, const Camera& camera, const RayCastParams& params,
               const VisibleLeaves& visible)
{
    params.validate();
    const glm::ivec2 size = camera.size();
    Image image{size, std::vector<glm::vec4>(std::size_t(size.x) * size.y, glm::vec4(0))};
    if (params.layers) image.layers.resize(image.pixels.size());
    const RayKernel kernel(volume, look, params, visible);
    const int tilesX = (size.x + kTile - 1) / kTile, tilesY = (size.y + kTile - 1) / kTile;
    tbb::parallel_for(0, tilesX * tilesY, [&](int tile) {
        const int beginX = tile % tilesX * kTile, beginY = tile / tilesX * kTile;
        std::vector<RayTask> tasks;
        tasks.reserve(kTile * kTile);
        for (int y = beginY; y < std::min(beginY + kTile, size.y); ++y) {
            for (int x = beginX; x < std::min(beginX + kTile, size.x); ++x) {
                tasks.push_back(prepareRay(volume, camera, params.step, x, y));
                if (tasks.back().samples == 0) tasks.pop_back();
            }
        }
        if (params.layers) {
            kernel.trace(tasks.data(), int(tasks.size()), image.pixels.data(), image.layers.data());
        } else {
            kernel.trace(tasks.data(), int(tasks.size()), image.pixels.data());
        }
    });
    return image;
}

Image castRays(const TextureVolume& volume, const Look& look, const Camera& camera, const RayCastParams& params)
{
    return castRays(volume, look, camera, params, VisibleLeaves(volume, look));
}

} // namespace vdblic
