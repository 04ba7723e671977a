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
    int first = 0, count = 0; ///< coarse voxels that the leaf depends on
    int before[kDim]{};       ///< number of the coarse voxel before each voxel
    Double4 weights[2][2]{};  ///< of the coarse voxels before and after it, in halves

    AxisPlaces(const Refinement& refinement, std::size_t axis, const openvdb::Coord& origin)
    {
        for (int i = 0; i < kDim; ++i) {
            const double position = (origin[int(axis)] + i + 0.5) / refinement.factors[axis] - 0.5,
                         base = std::floor(position);
            if (i == 0) first = int(base);
            before[i] = int(base) - first;
            weights[0][i / 4][i % 4] = 1 - (position - base);
            weights[1][i / 4][i % 4] = position - base;
        }
        count = before[kDim - 1] + 2;
    }
    [[nodiscard]] VDBLIC_INLINE double weight(int side, int i) const { return weights[side][i / 4][i % 4]; }
};

/// The values of a coarse grid at the voxels of a leaf that refines it, as valueAt() has them, to the bit.
class FinerLeaf {
  public:
    FinerLeaf(const openvdb::FloatGrid::ConstAccessor& values, const openvdb::Coord& origin,
              const Refinement& refinement)
        : mAxes{AxisPlaces(refinement, 0, origin), AxisPlaces(refinement, 1, origin), AxisPlaces(refinement, 2, origin)}
    {
        const auto& [x, y, z] = mAxes;
        for (int row = 0; row < x.count * y.count; ++row) {
            double coarse[kMost], coverage[kMost];
            for (int i = 0; i < z.count; ++i) {
                const openvdb::Coord voxel(x.first + row / y.count, y.first + row % y.count, z.first + i);
                float value = 0;
                const bool isActive = values.probeValue(voxel, value);
                coarse[i] = isActive ? double(value) : 0;
                coverage[i] = isActive ? 1 : 0;
            }
            for (int i = 0; i < 2 * kDim; ++i) {
                const int side = i / kDim, half = i / 4 % 2, at = z.before[i % kDim] + side;
                mRows[row].values[side][half][i % 4] = coarse[at];
                mRows[row].coverage[side][half][i % 4] = coverage[at];
            }
        }
    }

    /// @param result receives the values, in the order of a leaf
    VDBLIC_KERNEL
    void interpolate(float* result) const
    {
        const AxisPlaces &x = mAxes[0], &y = mAxes[1], &z = mAxes[2];
        for (int row = 0; row < LeafVoxel::kRows; ++row) {
            const LeafVoxel voxel = LeafVoxel::ofRow(row);
            const Row* coarse[4];
            double shares[4];
            for (int corner = 0; corner < 4; ++corner) {
                const int sideX = corner >> 1, sideY = corner & 1;
                coarse[corner] = &mRows[(x.before[voxel.x] + sideX) * y.count + y.before[voxel.y] + sideY];
                shares[corner] = x.weight(sideX, voxel.x) * y.weight(sideY, voxel.y);
            }
            for (int half = 0; half < 2; ++half) {
                Double4 sums{}, weights{};
                const auto add = [&](int corner, int side) {
                    const Double4 weight = shares[corner] * z.weights[side][half];
                    sums += weight * coarse[corner]->values[side][half];
                    weights += weight * coarse[corner]->coverage[side][half];
                };
                for (int corner = 0; corner < 4; ++corner) {
                    add(corner, 0);
                    add(corner, 1);
                }
                const Double4 means = weights > 0 ? sums / weights : Double4{};
                const auto four = __builtin_convertvector(means, Float4);
                __builtin_memcpy(result + std::ptrdiff_t(row) * kDim + half * std::ptrdiff_t(4), &four, sizeof four);
            }
        }
    }

  private:
    static constexpr int kMost = kDim + 2; // coarse voxels along an axis

    /// Coarse voxels of a row along z, before and after each voxel of the leaf.
    struct Row {
        Double4 values[2][2], coverage[2][2];
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
            FinerLeaf(accessor, leaf.origin(), *refinement).interpolate(leaf.buffer().data());
            for (auto voxel = leaf.beginValueOff(); voxel; ++voxel)
                voxel.setValue(0);
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
