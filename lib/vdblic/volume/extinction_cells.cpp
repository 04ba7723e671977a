#include "vdblic/volume/extinction_cells.h"

#include "vdblic/camera/clipping.h"
#include "vdblic/field/domain_rows.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/volume/leaf_extinctions.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <optional>

namespace vdblic {
namespace {

constexpr int kLeafCells = LeafVoxel::kDim / ExtinctionCell::kDim; // along an axis

/// The extinctions of a leaf's voxels, 0 where they are hidden.
VDBLIC_KERNEL
void leafExtinctions(const TextureVolume& volume, const Look& look, std::size_t leaf, float* extinctions)
{
    std::fill_n(extinctions, LeafVoxel::kCount, 0.0f);
    forExtinctions(volume, look, leaf,
                   [&](int x, int y, Float8 row) { storeRow(row, extinctions, LeafVoxel::row(x, y)); });
}

/// @param first voxel of the cell in its leaf
std::optional<ExtinctionCell> cellOf(const float* extinctions, const openvdb::Coord& first, const openvdb::Coord& leaf)
{
    constexpr float kMost = 0.25f; // of the largest
    const openvdb::Coord last = first.offsetBy(ExtinctionCell::kDim - 1);
    ExtinctionCell cell{0, {{last[0], last[1], last[2]}, {first[0], first[1], first[2]}}};
    float largest = 0;
    for (auto voxel = openvdb::CoordBBox(first, last).begin(); voxel; ++voxel) {
        const float extinction = extinctions[LeafVoxel::offset((*voxel)[0], (*voxel)[1], (*voxel)[2])];
        cell.extinction += std::uint64_t(double(extinction) / ExtinctionCell::kUnit);
        largest = std::max(largest, extinction);
    }
    if (cell.extinction == 0) return std::nullopt;
    for (auto voxel = openvdb::CoordBBox(first, last).begin(); voxel; ++voxel) {
        if (extinctions[LeafVoxel::offset((*voxel)[0], (*voxel)[1], (*voxel)[2])] < kMost * largest) continue;
        for (int axis = 0; axis < 3; ++axis) {
            int &low = cell.most.low[std::size_t(axis)], &high = cell.most.high[std::size_t(axis)];
            low = std::min(low, (*voxel)[axis]);
            high = std::max(high, (*voxel)[axis]);
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        cell.most.low[std::size_t(axis)] += leaf[axis];
        cell.most.high[std::size_t(axis)] += leaf[axis];
    }
    return cell;
}

} // namespace

std::vector<ExtinctionCell> extinctionCells(const TextureVolume& volume, const Look& look, const ClipParams& clip)
{
    const std::vector<ClipPlane> planes = clip.allPlanes();
    std::vector<std::vector<ExtinctionCell>> ofLeaves(volume.leafCount());
    tbb::parallel_for(std::size_t(0), volume.leafCount(), [&](std::size_t leaf) {
        if (!volume.isOwn(leaf) || volume.shown(leaf).isOff() || !look.contributes(volume.leafRange(leaf))) return;
        alignas(32) float extinctions[LeafVoxel::kCount];
        leafExtinctions(volume, look, leaf, extinctions);
        constexpr int kDim = ExtinctionCell::kDim;
        for (auto cell = openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(kLeafCells - 1)).begin(); cell; ++cell) {
            const openvdb::Coord first((*cell)[0] * kDim, (*cell)[1] * kDim, (*cell)[2] * kDim);
            const std::optional<ExtinctionCell> found = cellOf(extinctions, first, volume.origin(leaf));
            const auto isKept = [&] {
                return planes.empty() || !isCutAway(found->most.corners(volume.indexToWorld()), planes);
            };
            if (found && isKept()) ofLeaves[leaf].push_back(*found);
        }
    });
    std::vector<ExtinctionCell> cells;
    for (const std::vector<ExtinctionCell>& some : ofLeaves)
        cells.insert(cells.end(), some.begin(), some.end());
    return cells;
}

} // namespace vdblic
