#include "vdblic/cast/extinction_grid.h"

#include "vdblic/cast/tube_tree.h"
#include "vdblic/core/exchange.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/volume/leaf_extinctions.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

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

} // namespace

ExtinctionGrid::ExtinctionGrid(const TextureVolume& volume, const Look& look, Exchange& exchange)
{
    openvdb::CoordBBox box;
    for (std::size_t leaf = 0; leaf < volume.domain().leafCount(); ++leaf)
        box.expand(openvdb::CoordBBox::createCube(volume.domain().origin(leaf), LeafVoxel::kDim));
    if (box.empty()) box = {openvdb::Coord(0), openvdb::Coord(0)};
    cover(box);
    sum(volume, look, exchange);
}

ExtinctionGrid::ExtinctionGrid(const TubeTree& tree)
{
    const Tubes& tubes = tree.tubes();
    const auto voxel = [](const glm::dvec3& at) { return openvdb::Coord::round(openvdb::Vec3d(at.x, at.y, at.z)); };
    cover({voxel(tubes.low() + 0.5), voxel(tubes.high() - 0.5)});
    std::vector<std::uint64_t> sums(index(mDim - openvdb::Coord(1)) + 1);
    // A tube attenuates the light behind it once, whatever its thickness.
    tubes.forPieces(tree.cones(), mCell, [&](const Tubes::Piece& piece) {
        const auto share = double(tree.alpha(piece.driver, piece.opacity));
        openvdb::Coord cell = voxel(piece.place) - mOrigin;
        for (int axis = 0; axis < 3; ++axis)
            cell[axis] = std::clamp(cell[axis] / mCell, 0, mDim[axis] - 1);
        sums[index(cell)] += std::uint64_t(share * piece.area * double(kSumUnits));
    });
    setValues(sums);
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
void ExtinctionGrid::sum(const TextureVolume& volume, const Look& look, Exchange& exchange)
{
    const std::size_t count = std::size_t(mDim[0]) * std::size_t(mDim[1]) * std::size_t(mDim[2]);
    std::vector<std::uint64_t> sums(count);
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
    setValues(sums);
}

/// @param sums over the voxels of the cells [1/kSumUnits]
void ExtinctionGrid::setValues(const std::vector<std::uint64_t>& sums)
{
    const double perSum = 1 / (double(kSumUnits) * mCell * mCell * mCell);
    mValues.reserve(sums.size());
    for (const std::uint64_t sum : sums)
        mValues.push_back(float(double(sum) * perSum));
}

} // namespace vdblic
