#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"
#include "vdblic/volume/texture_records.h"
#include "vdblic/volume/texture_volume.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace vdblic {
namespace {

/// Eight symmetric matrices.
struct Symmetric8 {
    Float8 xx, yy, zz, xy, xz, yz;
};

/// The matrices over their traces; a third of the unit matrix where the trace is 0.
VDBLIC_INLINE Symmetric8 ofTraceOne(const Symmetric8& m)
{
    const Float8 trace = m.xx + m.yy + m.zz, perTrace = 1 / trace;
    const auto scaled = [&](Float8 x, float without) { return trace > 0 ? x * perTrace : broadcast8(without); };
    constexpr float kThird = 1 / 3.0f;
    return {scaled(m.xx, kThird), scaled(m.yy, kThird), scaled(m.zz, kThird),
            scaled(m.xy, 0),      scaled(m.xz, 0),      scaled(m.yz, 0)};
}

VDBLIC_INLINE Symmetric8 adjugate(const Symmetric8& m)
{
    const auto& [xx, yy, zz, xy, xz, yz] = m;
    return {yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy,
            xz * yz - xy * zz, xy * yz - xz * yy, xy * xz - yz * xx};
}

VDBLIC_INLINE Symmetric8 squared(const Symmetric8& m)
{
    const auto& [xx, yy, zz, xy, xz, yz] = m;
    return {xx * xx + xy * xy + xz * xz, xy * xy + yy * yy + yz * yz, xz * xz + yz * yz + zz * zz,
            xx * xy + xy * yy + xz * yz, xx * xz + xy * yz + xz * zz, xy * xz + yy * yz + yz * zz};
}

/// The projector on the direction in which a texture changes least, from its structure tensor: the mean of g·gᵀ over
/// the gradients g nearby.
///
/// The adjugate has that direction as its dominant eigenvector; squaring suppresses the others. Where no direction
/// dominates the result stays near a third of the unit matrix, which lights a sample evenly.
VDBLIC_INLINE Symmetric8 lineProjector(const Symmetric8& structure)
{
    Symmetric8 m = ofTraceOne(adjugate(ofTraceOne(structure)));
    for (int i = 0; i < 2; ++i)
        m = ofTraceOne(squared(m));
    return m;
}

/// The structure tensor around a leaf, smoothed by 1 2 1 along each axis; valid for the leaf's own voxels.
class StructureBlock {
  public:
    /// @param toWorld turns gradients into those in world space
    VDBLIC_INLINE void fill(const TextureRecord* records, const glm::mat3& toWorld)
    {
        constexpr int kRim = ScalarLeaf::kRim, kEnd = LeafVoxel::kDim + kRim;
        constexpr int kStrides[] = {TextureLeaf::kX, TextureLeaf::kY, 1};
        for (int x = -kRim; x < kEnd; ++x) {
            for (int y = -kRim; y < kEnd; ++y) {
                for (int z = -kRim; z < kEnd; ++z) {
                    const TextureRecord* const at = records + TextureLeaf::index(x, y, z);
                    float slopes[3], g[3];
                    for (int axis = 0; axis < 3; ++axis)
                        slopes[axis] = float(at[kStrides[axis]]) - float(at[-kStrides[axis]]);
                    for (int axis = 0; axis < 3; ++axis)
                        g[axis] =
                            toWorld[0][axis] * slopes[0] + toWorld[1][axis] * slopes[1] + toWorld[2][axis] * slopes[2];
                    const float products[] = {g[0] * g[0], g[1] * g[1], g[2] * g[2],
                                              g[0] * g[1], g[0] * g[2], g[1] * g[2]};
                    for (int k = 0; k < 6; ++k)
                        mValues[k][ScalarLeaf::index(x, y, z)] = products[k];
                }
            }
        }
        for (float* value : mValues) {
            float once[ScalarLeaf::kSize], twice[ScalarLeaf::kSize];
            smooth(value, once, 1);
            smooth(once, twice, ScalarLeaf::kY);
            smooth(twice, value, ScalarLeaf::kX);
        }
    }

    /// The tensors of eight consecutive records.
    VDBLIC_INLINE Symmetric8 row(int record) const
    {
        const auto load = [&](int k) {
            Float8 values;
            std::memcpy(&values, mValues[k] + record, sizeof values);
            return values;
        };
        return {load(0), load(1), load(2), load(3), load(4), load(5)};
    }

  private:
    /// The outermost records get no valid result.
    VDBLIC_INLINE static void smooth(const float* values, float* result, int stride)
    {
        std::copy(values, values + stride, result);
        for (int i = stride; i < ScalarLeaf::kSize - stride; ++i)
            result[i] = values[i - stride] + 2 * values[i] + values[i + stride];
        std::copy(values + ScalarLeaf::kSize - stride, values + ScalarLeaf::kSize, result + ScalarLeaf::kSize - stride);
    }

    float mValues[6][ScalarLeaf::kSize];
};

/// Write the records of a leaf's own voxels.
VDBLIC_KERNEL
void writeLines(const TextureRecord* records, const glm::mat3& gradientToWorld, LineRecord* lines)
{
    StructureBlock block;
    block.fill(records, gradientToWorld);
    for (int x = 0; x < LeafVoxel::kDim; ++x) {
        for (int y = 0; y < LeafVoxel::kDim; ++y) {
            const int first = ScalarLeaf::index(x, y, 0);
            const Symmetric8 line = lineProjector(block.row(first));
            Float8 rows[8] = {line.xx, line.yy, line.zz, line.xy, line.xz, line.yz};
            transpose(rows, rows);
            for (int z = 0; z < LeafVoxel::kDim; ++z) {
                for (int k = 0; k < 8; ++k)
                    lines[first + z].values[k] = toBFloat16(rows[z][k]);
            }
        }
    }
}

} // namespace

void TextureVolume::addLines()
{
    const std::size_t leaves = leafCount();
    mLines = std::make_unique_for_overwrite<LineRecord[]>(leaves * ScalarLeaf::kSize);
    tbb::parallel_for(std::size_t(0), leaves, [&](std::size_t leaf) {
        writeLines(records(leaf), mGradientToWorld, mLines.get() + leaf * ScalarLeaf::kSize);
    });
    // The padding is copied from the neighbouring leaves, or where there is none from the leaf's own nearest voxels.
    tbb::parallel_for(std::size_t(0), leaves, [&](std::size_t leaf) {
        const openvdb::Coord first = origin(leaf);
        LineRecord* const padded = mLines.get() + leaf * ScalarLeaf::kSize;
        const auto begin = [](int side) { return side < 0 ? -1 : side * LeafVoxel::kDim; };
        const auto end = [](int side) { return side < 0 ? 0 : LeafVoxel::kDim + side; };
        for (const openvdb::Coord& side : openvdb::CoordBBox(openvdb::Coord(-1), openvdb::Coord(1))) {
            if (side == openvdb::Coord(0)) continue;
            const int found = findLeaf(
                first.offsetBy(side[0] * LeafVoxel::kDim, side[1] * LeafVoxel::kDim, side[2] * LeafVoxel::kDim));
            const LineRecord* const source =
                found >= 0 ? mLines.get() + std::size_t(found) * ScalarLeaf::kSize : padded;
            const auto inside = [&](int i) {
                return found >= 0 ? LeafVoxel::local(i) : std::clamp(i, 0, LeafVoxel::kDim - 1);
            };
            for (int x = begin(side[0]); x < end(side[0]); ++x) {
                for (int y = begin(side[1]); y < end(side[1]); ++y) {
                    for (int z = begin(side[2]); z < end(side[2]); ++z)
                        padded[ScalarLeaf::index(x, y, z)] = source[ScalarLeaf::index(inside(x), inside(y), inside(z))];
                }
            }
        }
    });
}

} // namespace vdblic
