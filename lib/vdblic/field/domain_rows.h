#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"

#include <cstddef>
#include <cstdint>

namespace vdblic {

/// The centres of a row's eight voxels. @param x, y, z of the first
[[nodiscard]] VDBLIC_INLINE Vector8 rowCentres(int x, int y, int z)
{
    return {broadcast8(float(x)), broadcast8(float(y)), Float8{0, 1, 2, 3, 4, 5, 6, 7} + float(z)};
}

/// The numbers of a leaf's voxels in one row. @param values of the leaf, x slowest
[[nodiscard]] VDBLIC_INLINE Float8 loadRow(const float* values, int row)
{
    Float8 numbers;
    __builtin_memcpy(&numbers, values + row * std::ptrdiff_t(LeafVoxel::kDim), sizeof numbers);
    return numbers;
}
[[nodiscard]] VDBLIC_INLINE Int8 loadRow(const std::int32_t* values, int row)
{
    Int8 numbers;
    __builtin_memcpy(&numbers, values + row * std::ptrdiff_t(LeafVoxel::kDim), sizeof numbers);
    return numbers;
}
VDBLIC_INLINE void storeRow(Float8 numbers, float* values, int row)
{
    __builtin_memcpy(values + row * std::ptrdiff_t(LeafVoxel::kDim), &numbers, sizeof numbers);
}
VDBLIC_INLINE void storeRow(Int8 numbers, std::int32_t* values, int row)
{
    __builtin_memcpy(values + row * std::ptrdiff_t(LeafVoxel::kDim), &numbers, sizeof numbers);
}

/// A lane mask of a row's active voxels. @param mask of the leaf
[[nodiscard]] VDBLIC_INLINE Int8 activeRow(const Domain::Mask& mask, int row)
{
    return maskOf(mask.getWord<std::uint8_t>(openvdb::Index(row)));
}

/// Whether a position, in index space, lies in an active voxel.
[[nodiscard]] VDBLIC_INLINE bool covers(const Domain& domain, Float4 position)
{
    const Int4 voxel = voxelOf(position);
    const int leaf = domain.findLeaf(voxel);
    return leaf >= 0 && domain.isActive(leaf, Domain::offset(voxel));
}

/// Call visit(leaf, offset, weight) for each active corner of the cell around a position in index space, with its
/// trilinear weight.
template<typename Visit>
VDBLIC_INLINE void forCorners(const Domain& domain, Float4 position, const Visit& visit)
{
    const Int4 base = floorToInt(position);
    const Float4 fraction = position - __builtin_convertvector(base, Float4);
    for (int corner = 0; corner < 8; ++corner) {
        const Int4 step = {corner >> 2, corner >> 1 & 1, corner & 1, 0};
        const auto voxel = Int4(Unsigned4(base) + Unsigned4(step)); // wraps around far outside
        const int leaf = domain.findLeaf(voxel);
        if (leaf < 0 || !domain.isActive(leaf, Domain::offset(voxel))) continue;
        float weight = 1;
        for (int axis = 0; axis < 3; ++axis)
            weight *= step[axis] ? fraction[axis] : 1 - fraction[axis];
        visit(std::size_t(leaf), Domain::offset(voxel), weight);
    }
}

} // namespace vdblic
