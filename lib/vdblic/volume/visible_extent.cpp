#include "vdblic/volume/visible_extent.h"

#include "vdblic/camera/clipping.h"
#include "vdblic/core/exchange.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/volume/extinction_cells.h"
#include "vdblic/volume/texture_volume.h"
#include "vdblic/volume/voxel_box.h"

#include <glm/common.hpp>
#include <openvdb/openvdb.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdblic {
namespace {

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
    std::vector<VoxelBox> seen;
    for (const ExtinctionCell& cell : cells) {
        const openvdb::Coord place = cell.place() - box.min();
        const auto isSeen = [&](const DepthPicture& picture) { return picture.depth(place) >= least; };
        if (std::all_of(pictures.begin(), pictures.end(), isSeen)) seen.push_back(cell.most);
    }
    const glm::dvec3 extent = volume.high() - volume.low();
    std::vector<glm::dvec3> points;
    for (const VoxelBox& cell : outermost(exchange.join(outermost(seen, extent)), extent)) {
        const auto corners = cell.corners(volume.indexToWorld());
        points.insert(points.end(), corners.begin(), corners.end());
    }
    return points;
}

} // namespace vdblic
