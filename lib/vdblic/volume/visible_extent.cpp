#include "vdblic/volume/visible_extent.h"

#include "vdblic/camera/clipping.h"
#include "vdblic/core/exchange.h"
#include "vdblic/field/domain_rows.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/volume/inclusive_box.h"
#include "vdblic/volume/leaf_extinctions.h"
#include "vdblic/volume/texture_volume.h"

#include <glm/common.hpp>
#include <openvdb/openvdb.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {
namespace {

/// A cube of voxels with visible ones under a look.
struct ExtinctionCell {
    static constexpr int kLog2Dim = 2, kDim = 1 << kLog2Dim;
    static constexpr double kUnit = 1 / double(1 << 20); ///< sums of integers do not depend on their order

    std::uint64_t extinction; ///< sum over its voxels [kUnit]
    InclusiveBox most;        ///< around the voxels with most of the extinction

    /// In cells.
    [[nodiscard]] openvdb::Coord place() const { return at(openvdb::Coord(most.low.data())); }
    [[nodiscard]] static openvdb::Coord at(const openvdb::Coord& voxel)
    {
        return {voxel[0] >> kLog2Dim, voxel[1] >> kLog2Dim, voxel[2] >> kLog2Dim};
    }
};

/// The extinctions of a leaf's voxels, 0 where they are hidden.
VDBLIC_KERNEL
void leafExtinctions(const TextureVolume& volume, const Look& look, std::size_t leaf, float* extinctions)
{
    std::fill_n(extinctions, LeafVoxel::kCount, 0.0f);
    forExtinctions(volume, look, leaf,
                   [&](int x, int y, Float8 row) { storeRow(row, extinctions, LeafVoxel::row(x, y)); });
}

/// The two cells of a leaf that lie along a row, each in half of the lanes. Their extinctions may be 0.
/// @param extinctions of the leaf's voxels  @param first voxel of the row
VDBLIC_KERNEL
std::array<ExtinctionCell, 2> cellsAt(const float* extinctions, const openvdb::Coord& origin,
                                      const openvdb::Coord& first)
{
    constexpr int kDim = ExtinctionCell::kDim, kRows = kDim * kDim;
    constexpr unsigned kLanesOfCell = (1u << kDim) - 1;
    constexpr float kMost = 0.25f; // of the largest
    static_assert(2 * kDim == kLanes && LeafVoxel::kDim == kLanes);
    const auto rowAt = [&](int i) {
        return loadRow(extinctions, LeafVoxel::row(first[0] + i / kDim, first[1] + i % kDim));
    };
    Int8 sums{}; // of a lane, at most 16 of extinctions below 14: opacity is never 1
    Float8 largest{};
    for (int i = 0; i < kRows; ++i) {
        const Float8 row = rowAt(i);
        sums += __builtin_convertvector(row * float(1 / ExtinctionCell::kUnit), Int8);
        largest = row > largest ? row : largest;
    }
    Float8 least;
    for (int lane = 0; lane < kLanes; lane += kDim) {
        const float most = std::max({largest[lane], largest[lane + 1], largest[lane + 2], largest[lane + 3]});
        for (int z = 0; z < kDim; ++z)
            least[lane + z] = kMost * most;
    }
    std::array<std::array<unsigned, kDim>, 2> lanes{}; // with most of the extinction, by steps along x and along y
    for (int i = 0; i < kRows; ++i) {
        const unsigned bits = laneBits(rowAt(i) >= least);
        lanes[0][std::size_t(i / kDim)] |= bits;
        lanes[1][std::size_t(i % kDim)] |= bits;
    }
    std::array<ExtinctionCell, 2> cells{};
    for (int z = 0; z < LeafVoxel::kDim; z += kDim) {
        ExtinctionCell& cell = cells[std::size_t(z / kDim)];
        unsigned bits[3]{}; // of steps along the axes
        for (int i = 0; i < kDim; ++i) {
            cell.extinction += unsigned(sums[z + i]);
            bits[2] |= lanes[0][std::size_t(i)] >> z & kLanesOfCell;
            for (std::size_t axis = 0; axis < 2; ++axis)
                bits[axis] |= unsigned((lanes[axis][std::size_t(i)] >> z & kLanesOfCell) != 0) << i;
        }
        for (int axis = 0; axis < 3; ++axis) {
            const int start = origin[axis] + first[axis] + (axis == 2 ? z : 0);
            cell.most.low[std::size_t(axis)] = start + std::countr_zero(bits[axis]);
            cell.most.high[std::size_t(axis)] = start + std::bit_width(bits[axis]) - 1;
        }
    }
    return cells;
}

/// The cells of a rank's own leaves, in the order of the leaves. Hidden voxels and cells that are cut away do not
/// count.
/// @param clip in the volume's world space
std::vector<ExtinctionCell> extinctionCells(const TextureVolume& volume, const Look& look, const ClipParams& clip)
{
    const std::vector<ClipPlane> planes = clip.allPlanes();
    std::vector<std::vector<ExtinctionCell>> ofLeaves(volume.leafCount());
    tbb::parallel_for(std::size_t(0), volume.leafCount(), [&](std::size_t leaf) {
        if (!volume.isOwn(leaf) || volume.shown(leaf).isOff() || !look.contributes(volume.leafRange(leaf))) return;
        alignas(32) float extinctions[LeafVoxel::kCount];
        leafExtinctions(volume, look, leaf, extinctions);
        for (int i = 0; i < 4; ++i) {
            const openvdb::Coord first(i / 2 * ExtinctionCell::kDim, i % 2 * ExtinctionCell::kDim, 0);
            for (const ExtinctionCell& cell : cellsAt(extinctions, volume.origin(leaf), first)) {
                const auto isCut = [&] {
                    return !planes.empty() && isCutAway(cell.most.corners(volume.indexToWorld()), planes);
                };
                if (cell.extinction > 0 && !isCut()) ofLeaves[leaf].push_back(cell);
            }
        }
    });
    std::vector<ExtinctionCell> cells;
    for (const std::vector<ExtinctionCell>& some : ofLeaves)
        cells.insert(cells.end(), some.begin(), some.end());
    return cells;
}

constexpr double kLeastDepth = 0.01;     // optical depth of a line that counts as visible
constexpr double kLeastDepthShare = 0.1; // or this share of the largest of a line
constexpr int kMostPixels = 256;         // of a picture of cells, along an edge of the box

/// Along the edges of a cube, the diagonals of its faces and its diagonals.
constexpr std::array<std::array<int, 3>, 13> kLineDirections{{{1, 0, 0},
                                                              {0, 1, 0},
                                                              {0, 0, 1},
                                                              {1, 1, 0},
                                                              {1, -1, 0},
                                                              {1, 0, 1},
                                                              {1, 0, -1},
                                                              {0, 1, 1},
                                                              {0, 1, -1},
                                                              {1, 1, 1},
                                                              {1, 1, -1},
                                                              {1, -1, 1},
                                                              {-1, 1, 1}}};

/// The optical depths of lines through all cells in one direction. Cells on one line have the same pixel.
class DepthPicture {
  public:
    /// @param dim of the box around all cells
    DepthPicture(const std::array<int, 3>& direction, const openvdb::Coord& dim) : mDirection(direction)
    {
        while (direction[std::size_t(mAlong)] == 0)
            ++mAlong;
        while (std::max({dim[0], dim[1], dim[2]}) >> mShift > kMostPixels)
            ++mShift;
        double length = 0;
        for (int i = 0; i < 2; ++i) {
            const int across = (mAlong + 1 + i) % 3;
            mFirst[i] = -(dim[mAlong] - 1);
            mSize[i] = ((dim[across] + 2 * dim[mAlong]) >> mShift) + 1;
        }
        for (const int component : direction)
            length += component * component;
        // The voxels of a line of cells, over the area that is theirs across the line: a volume over its base.
        constexpr double kVolume = ExtinctionCell::kDim * ExtinctionCell::kDim;
        mDepthPerSum = ExtinctionCell::kUnit * std::sqrt(length) / (kVolume * std::pow(4, mShift));
        mSums.resize(std::size_t(mSize[0]) * std::size_t(mSize[1]));
    }

    /// @param place relative to the first cell of the box
    void add(const openvdb::Coord& place, std::uint64_t extinction) { mSums[pixel(place)] += extinction; }
    void join(Exchange& exchange) { exchange.sum(mSums); }
    [[nodiscard]] double depth(const openvdb::Coord& place) const { return depthOf(mSums[pixel(place)]); }
    [[nodiscard]] double mostDepth() const { return depthOf(*std::max_element(mSums.begin(), mSums.end())); }

  private:
    [[nodiscard]] double depthOf(std::uint64_t sum) const { return double(sum) * mDepthPerSum; }
    [[nodiscard]] std::size_t pixel(const openvdb::Coord& place) const
    {
        const int steps = place[mAlong] * mDirection[std::size_t(mAlong)];
        std::array<int, 2> at{};
        for (int i = 0; i < 2; ++i) {
            const int across = (mAlong + 1 + i) % 3;
            at[std::size_t(i)] = (place[across] - mDirection[std::size_t(across)] * steps - mFirst[i]) >> mShift;
        }
        return std::size_t(at[0]) * std::size_t(mSize[1]) + std::size_t(at[1]);
    }

    std::array<int, 3> mDirection;
    int mAlong = 0, mShift = 0;
    int mFirst[2], mSize[2];
    double mDepthPerSum;
    std::vector<std::uint64_t> mSums;
};

/// The pictures of all ranks' cells in all directions. Collective.
std::vector<DepthPicture> depthPictures(const std::vector<ExtinctionCell>& cells, const openvdb::Coord& first,
                                        const openvdb::Coord& dim, Exchange& exchange)
{
    std::vector<DepthPicture> pictures;
    pictures.reserve(kLineDirections.size());
    for (const auto& direction : kLineDirections)
        pictures.emplace_back(direction, dim);
    tbb::parallel_for(std::size_t(0), pictures.size(), [&](std::size_t i) {
        for (const ExtinctionCell& cell : cells)
            pictures[i].add(cell.place() - first, cell.extinction);
    });
    if (!exchange.isAlone()) {
        for (DepthPicture& picture : pictures)
            picture.join(exchange);
    }
    return pictures;
}

} // namespace

std::vector<glm::dvec3> visibleExtent(const TextureVolume& volume, const Look& look, const ClipParams& clip,
                                      Exchange& exchange)
{
    if (volume.empty()) return {};
    const std::vector<ExtinctionCell> cells = extinctionCells(volume, look, clip);
    openvdb::CoordBBox box; // in cells
    for (std::size_t leaf = 0; leaf < volume.domain().leafCount(); ++leaf)
        box.expand(ExtinctionCell::at(volume.domain().origin(leaf)));
    box.expand(box.max().offsetBy(LeafVoxel::kDim / ExtinctionCell::kDim - 1));
    const std::vector<DepthPicture> pictures = depthPictures(cells, box.min(), box.dim(), exchange);
    double most = 0;
    for (const DepthPicture& picture : pictures)
        most = std::max(most, picture.mostDepth());
    const double least = std::min(kLeastDepth, kLeastDepthShare * most);
    std::vector<InclusiveBox> seen;
    for (const ExtinctionCell& cell : cells) {
        const openvdb::Coord place = cell.place() - box.min();
        const auto isSeen = [&](const DepthPicture& picture) { return picture.depth(place) >= least; };
        if (std::all_of(pictures.begin(), pictures.end(), isSeen)) seen.push_back(cell.most);
    }
    const glm::dvec3 extent = volume.high() - volume.low();
    std::vector<glm::dvec3> points;
    for (const InclusiveBox& cell : outermost(exchange.join(outermost(seen, extent)), extent)) {
        const auto corners = cell.corners(volume.indexToWorld());
        points.insert(points.end(), corners.begin(), corners.end());
    }
    return points;
}

} // namespace vdblic
