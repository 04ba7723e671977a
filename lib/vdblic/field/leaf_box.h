#pragma once

#include "vdblic/field/leaf_voxel.h"

#include <openvdb/openvdb.h>

#include <bit>
#include <cstdint>

namespace vdblic {

/// A range of coordinates in a leaf along one axis.
struct LeafSpan {
    std::int8_t first = 0, last = -1; ///< empty by default
    [[nodiscard]] constexpr bool isEmpty() const { return last < first; }
    constexpr bool operator==(const LeafSpan&) const = default;
};

/// The box around a leaf's active voxels.
struct LeafBox {
    LeafSpan spans[3];   ///< along x, y and z
    bool isExact = true; ///< whether all voxels of the box are active
    bool isFull = false; ///< whether all voxels of the leaf are active

    /// An empty box.
    LeafBox() = default;
    explicit LeafBox(const openvdb::util::NodeMask<LeafVoxel::kLog2Dim>& mask)
    {
        std::uint64_t plane = 0; // union of all planes across x
        unsigned planes = 0, rows = 0, voxels = 0;
        for (int x = 0; x < LeafVoxel::kDim; ++x) {
            const auto part = mask.getWord<std::uint64_t>(openvdb::Index(x));
            plane |= part;
            planes |= unsigned(part != 0) << x;
        }
        for (int y = 0; y < LeafVoxel::kDim; ++y) {
            const auto row = unsigned(plane >> y * LeafVoxel::kDim & 0xff);
            voxels |= row;
            rows |= unsigned(row != 0) << y;
        }
        unsigned count = 1;
        const unsigned parts[3] = {planes, rows, voxels};
        for (int axis = 0; axis < 3; ++axis) {
            spans[axis] = {std::int8_t(std::countr_zero(parts[axis])), std::int8_t(std::bit_width(parts[axis]) - 1)};
            count *= unsigned(spans[axis].last - spans[axis].first + 1);
        }
        if (planes == 0) {
            *this = LeafBox();
            return;
        }
        isExact = count == mask.countOn();
        isFull = mask.isOn();
    }
};

} // namespace vdblic
