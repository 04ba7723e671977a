#pragma once

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

class Exchange;
class PlacedBox;
class TextureVolume;
class ShownTubes;
struct Look;

/// The extinction of a volume's visible voxels under a look, on a coarse grid over the volume's bounds.
///
/// A cell holds the mean extinction of its voxels [1/voxel]. Cells are cubes of 2 voxels or more, so many that their
/// number stays below a million whatever the volume's extent. Ranks that share the volume add up their own leaves, and
/// each has the whole grid. Immutable; any number of threads may read.
class ExtinctionGrid {
  public:
    /// @param exchange of the ranks that share the volume: collective
    /// @param tubes    in the volume or around it, at most as far as it is long; or null
    ExtinctionGrid(const TextureVolume& volume, const Look& look, Exchange& exchange,
                   const ShownTubes* tubes = nullptr);
    /// The extinction of tubes, each taken as short pieces spread evenly through its cells.
    explicit ExtinctionGrid(const ShownTubes& shown);

    [[nodiscard]] const openvdb::Coord& origin() const { return mOrigin; } ///< first voxel of the first cell
    [[nodiscard]] const openvdb::Coord& dim() const { return mDim; }       ///< number of cells, at least 2
    [[nodiscard]] int cell() const { return mCell; }                       ///< edge of a cell [voxels]
    /// Number of a cell. @param cell from 0 to dim() − 1
    [[nodiscard]] std::size_t index(const openvdb::Coord& cell) const
    {
        return (std::size_t(cell[0]) * std::size_t(mDim[1]) + std::size_t(cell[1])) * std::size_t(mDim[2]) +
               std::size_t(cell[2]);
    }
    [[nodiscard]] const std::vector<float>& values() const { return mValues; } ///< by x, then y, then z

  private:
    void cover(const openvdb::CoordBBox& voxels);
    using Sums = std::vector<std::uint64_t>; // over the voxels of the cells
    [[nodiscard]] Sums sum(const TextureVolume& volume, const Look& look, Exchange& exchange) const;
    void add(const ShownTubes& shown, const PlacedBox& box, Sums& sums) const;
    void setValues(const Sums& sums);

    openvdb::Coord mOrigin{0}, mDim{2};
    int mCell = 2;
    std::vector<float> mValues;
};

} // namespace vdblic
