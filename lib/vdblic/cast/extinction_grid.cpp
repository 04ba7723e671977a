#include "vdblic/cast/extinction_grid.h"

#include "vdblic/cast/shown_tubes.h"
#include "vdblic/core/exchange.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/volume/leaf_extinctions.h"

#include <glm/vec4.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vdblic {
namespace {

constexpr std::size_t kMostCells = 1 << 20;
constexpr float kSumUnits = 0x1p32f; // in which extinctions are summed up

/// Add a leaf's extinctions to sums over cells. @param from its first voxel, relative to the first cell's
VDBLIC_KERNEL
void addExtinctions(const TextureVolume& volume, const Look& look, std::size_t leaf, const openvdb::Coord& from,
                    int cell, const openvdb::Coord& dim, std::uint64_t* sums)
{
    forExtinctions(volume, look, leaf, [&](int x, int y, Float8 extinctions) {
        const std::ptrdiff_t row =
            (std::ptrdiff_t((from[0] + x) / cell) * dim[1] + (from[1] + y) / cell) * std::ptrdiff_t(dim[2]);
        for (int z = 0; z < kLanes; ++z)
            sums[row + (from[2] + z) / cell] += std::uint64_t(extinctions[z] * kSumUnits);
    });
}

openvdb::Coord voxelAt(const glm::dvec3& at)
{
    return openvdb::Coord::round(openvdb::Vec3d(at.x, at.y, at.z));
}

/// A volume's voxels and those around its tubes, so far as they lie no farther from it than it is long.
openvdb::CoordBBox withTubes(const openvdb::CoordBBox& voxels, const PlacedBox& volume, const Tubes& tubes)
{
    const openvdb::Coord dim = voxels.dim();
    const int most = std::max({dim[0], dim[1], dim[2]});
    constexpr int kFar = 1 << 28;
    if (most > kFar || voxels.min()[voxels.min().minIndex()] < -kFar || voxels.max()[voxels.max().maxIndex()] > kFar)
        return voxels;
    const auto inReach = [&](int axis, double at) {
        return int(std::clamp(at, double(voxels.min()[axis]) - most, double(voxels.max()[axis]) + most));
    };
    openvdb::CoordBBox box = voxels;
    for (const glm::dvec3& corner : tubes.corners()) {
        const glm::dvec3 at(volume.worldToIndex() * glm::dvec4(corner, 1));
        box.expand({inReach(0, at.x), inReach(1, at.y), inReach(2, at.z)});
    }
    return box;
}

} // namespace

ExtinctionGrid::ExtinctionGrid(const TextureVolume& volume, const Look& look, Exchange& exchange,
                               const ShownTubes* tubes)
{
    openvdb::CoordBBox box;
    for (std::size_t leaf = 0; leaf < volume.domain().leafCount(); ++leaf)
        box.expand(openvdb::CoordBBox::createCube(volume.domain().origin(leaf), LeafVoxel::kDim));
    if (box.empty()) box = {openvdb::Coord(0), openvdb::Coord(0)};
    if (tubes) box = withTubes(box, volume, tubes->tubes());
    cover(box);
    Sums sums = sum(volume, look, exchange);
    if (tubes) add(*tubes, volume, sums);
    setValues(sums);
}

ExtinctionGrid::ExtinctionGrid(const ShownTubes& shown)
{
    const Tubes& tubes = shown.tubes();
    cover({voxelAt(tubes.low() + 0.5), voxelAt(tubes.high() - 0.5)});
    Sums sums(index(mDim - openvdb::Coord(1)) + 1);
    add(shown, tubes, sums);
    setValues(sums);
}

/// Add tubes. One attenuates the light behind it once, whatever its thickness.
/// @param box whose voxels the cells cover
void ExtinctionGrid::add(const ShownTubes& shown, const PlacedBox& box, Sums& sums) const
{
    const Tubes& tubes = shown.tubes();
    const bool isOwn = &box == &tubes;
    const glm::dmat4 toBox = box.worldToIndex() * tubes.indexToWorld();
    const double scale = isOwn ? 1 : tubes.voxelSize() / box.voxelSize();
    const int cellOfTubes = int(std::clamp(mCell / scale, 1.0, 1e6));
    const auto addPiece = [&](const Tubes::Piece& piece) {
        const auto share = double(shown.alpha(broadcast8(piece.driver), broadcast8(piece.opacity))[0]);
        const glm::dvec3 place = isOwn ? piece.place : glm::dvec3(toBox * glm::dvec4(piece.place, 1));
        openvdb::Coord cell;
        for (int axis = 0; axis < 3; ++axis) {
            const double from = std::floor(place[axis] + 0.5) - mOrigin[axis], last = double(mCell) * mDim[axis] - 1;
            if (!isOwn && !(from >= 0 && from <= last)) return;
            cell[axis] = int(std::clamp(from, 0.0, last)) / mCell;
        }
        const double most = 0x1p60, area = piece.area * scale * scale;
        const auto sum = std::uint64_t(std::min(share * area * double(kSumUnits), most));
        std::atomic_ref(sums[index(cell)]).fetch_add(sum, std::memory_order_relaxed); // order does not matter
    };
    const std::span<const std::uint32_t> cones = shown.cones();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cones.size(), 256), [&](const auto& range) {
        tubes.forPieces(cones.subspan(range.begin(), range.size()), cellOfTubes, addPiece);
    });
}

/// Set the cells. @param voxels that they cover, not empty
void ExtinctionGrid::cover(const openvdb::CoordBBox& voxels)
{
    mOrigin = voxels.min();
    const auto cells = [&] {
        for (int axis = 0; axis < 3; ++axis)
            mDim[axis] = std::max((voxels.max()[axis] - mOrigin[axis]) / mCell + 1, 2);
        return double(mDim[0]) * mDim[1] * mDim[2];
    };
    while (cells() > double(kMostCells))
        mCell *= 2;
}

/// Sums are of integers, so their order does not matter.
ExtinctionGrid::Sums ExtinctionGrid::sum(const TextureVolume& volume, const Look& look, Exchange& exchange) const
{
    Sums sums(index(mDim - openvdb::Coord(1)) + 1);
    const auto addLeaf = [&](std::size_t leaf) {
        if (!volume.isOwn(leaf) || volume.shown(leaf).isOff() || !look.contributes(volume.leafRange(leaf))) return;
        addExtinctions(volume, look, leaf, volume.origin(leaf) - mOrigin, mCell, mDim, sums.data());
    };
    // A cell larger than a leaf adds up several leaves.
    if (mCell <= LeafVoxel::kDim) {
        tbb::parallel_for(std::size_t(0), volume.leafCount(), addLeaf);
    } else {
        for (std::size_t leaf = 0; leaf < volume.leafCount(); ++leaf)
            addLeaf(leaf);
    }
    exchange.sum(sums);
    return sums;
}

/// @param sums over the voxels of the cells [1/kSumUnits]
void ExtinctionGrid::setValues(const Sums& sums)
{
    const double perSum = 1 / (double(kSumUnits) * mCell * mCell * mCell);
    mValues.reserve(sums.size());
    for (const std::uint64_t sum : sums)
        mValues.push_back(float(double(sum) * perSum));
}

} // namespace vdblic
