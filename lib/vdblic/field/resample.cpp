#include "vdblic/field/resample.h"

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/refinement.h"
#include "vdblic/field/trilinear.h"
#include "vdblic/field/vector.h"

#include <openvdb/tree/LeafManager.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>

namespace vdblic {
namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;
constexpr int kDim = LeafVoxel::kDim;

/// The voxels of a leaf along an axis, between the coarse voxels that they refine.
struct AxisPlaces {
    int first = 0, count = 0;  ///< coarse voxels that the leaf depends on
    int before[kDim]{};        ///< number of the coarse voxel before each voxel
    double weights[2][kDim]{}; ///< of the coarse voxels before and after it

    AxisPlaces(const Refinement& refinement, std::size_t axis, const openvdb::Coord& origin)
    {
        for (int i = 0; i < kDim; ++i) {
            const double position = (origin[int(axis)] + i + 0.5) / refinement.factors[axis] - 0.5,
                         base = std::floor(position);
            if (i == 0) first = int(base);
            before[i] = int(base) - first;
            weights[0][i] = 1 - (position - base);
            weights[1][i] = position - base;
        }
        count = before[kDim - 1] + 2;
    }
};

/// The values of a coarse grid at the voxels of a leaf that refines it, as valueAt() has them, to the bit.
class FinerLeaf {
  public:
    FinerLeaf(const openvdb::FloatGrid::ConstAccessor& values, const openvdb::Coord& origin,
              const Refinement& refinement)
        : mAxes{AxisPlaces(refinement, 0, origin), AxisPlaces(refinement, 1, origin), AxisPlaces(refinement, 2, origin)}
    {
        const auto& [x, y, z] = mAxes;
        float coarse[kMost];
        bool active[kMost];
        for (int row = 0; row < x.count * y.count; ++row) {
            for (int i = 0; i < z.count; ++i) {
                const openvdb::Coord voxel(x.first + row / y.count, y.first + row % y.count, z.first + i);
                active[i] = values.probeValue(voxel, coarse[i]);
            }
            for (int side = 0; side < 2; ++side) {
                for (int i = 0; i < kDim; ++i) {
                    const int at = z.before[i] + side;
                    mRows[row].values[side][i] = active[at] ? double(coarse[at]) : 0;
                    mRows[row].coverage[side][i] = active[at] ? 1 : 0;
                }
            }
        }
    }

    /// @param result receives the values, in the order of a leaf
    VDBLIC_KERNEL
    void interpolate(float* result) const
    {
        const auto& [x, y, z] = mAxes;
        for (int row = 0; row < LeafVoxel::kRows; ++row) {
            const LeafVoxel voxel = LeafVoxel::ofRow(row);
            double sums[kDim]{}, weights[kDim]{};
            for (int corner = 0; corner < 4; ++corner) {
                const int sideX = corner >> 1, sideY = corner & 1;
                const Row& coarse = mRows[(x.before[voxel.x] + sideX) * y.count + y.before[voxel.y] + sideY];
                const double share = x.weights[sideX][voxel.x] * y.weights[sideY][voxel.y];
                for (int side = 0; side < 2; ++side) {
                    for (int i = 0; i < kDim; ++i) {
                        const double weight = share * z.weights[side][i];
                        sums[i] += weight * coarse.values[side][i];
                        weights[i] += weight * coarse.coverage[side][i];
                    }
                }
            }
            for (int i = 0; i < kDim; ++i)
                result[row * kDim + i] = weights[i] > 0 ? float(sums[i] / weights[i]) : 0;
        }
    }

  private:
    static constexpr int kMost = kDim + 2; // coarse voxels along an axis

    /// Coarse voxels of a row along z, before and after each voxel of the leaf.
    struct Row {
        double values[2][kDim], coverage[2][kDim];
    };

    std::array<AxisPlaces, 3> mAxes;
    Row mRows[kMost * kMost];
};

} // namespace

openvdb::FloatGrid::Ptr resampled(const openvdb::FloatGrid& values, const openvdb::FloatGrid& like)
{
    auto tree = std::make_shared<openvdb::FloatTree>(0.0f);
    for (auto leaf = like.tree().cbeginLeaf(); leaf; ++leaf) {
        if (!leaf->buffer().empty()) tree->addLeaf(new Leaf(*leaf, 0.0f, openvdb::TopologyCopy())); // takes it over
    }
    auto tile = like.tree().cbeginValueOn();
    tile.setMaxDepth(openvdb::FloatTree::ValueOnCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile)
        tree->fill(tile.getBoundingBox(), 0.0f);
    tree->voxelizeActiveTiles();
    const std::optional<Refinement> refinement = Refinement::between(values.transform(), like.transform());
    openvdb::tree::LeafManager<openvdb::FloatTree> leaves(*tree);
    leaves.foreach ([&](Leaf& leaf, std::size_t) {
        const openvdb::FloatGrid::ConstAccessor accessor = values.getConstAccessor();
        if (refinement) {
            float result[LeafVoxel::kCount];
            FinerLeaf(accessor, leaf.origin(), *refinement).interpolate(result);
            for (auto voxel = leaf.beginValueOn(); voxel; ++voxel)
                voxel.setValue(result[voxel.pos()]);
            return;
        }
        for (auto voxel = leaf.beginValueOn(); voxel; ++voxel)
            voxel.setValue(valueAt(accessor, values.worldToIndex(like.indexToWorld(voxel.getCoord()))));
    });
    auto grid = openvdb::FloatGrid::create(tree);
    grid->insertMeta(values);
    grid->setTransform(like.transform().copy());
    return grid;
}

} // namespace vdblic
