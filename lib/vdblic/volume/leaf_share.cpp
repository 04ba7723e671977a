#include "vdblic/volume/leaf_share.h"

#include "vdblic/field/leaf_voxel.h"

#include <algorithm>
#include <cstdint>

namespace vdblic {

BoxShare::BoxShare(const openvdb::CoordBBox& bounds, int rank, int ranks) : LeafShare(ranks)
{
    const openvdb::CoordBBox box = bounds.empty() ? openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(0)) : bounds;
    constexpr int kFar = 1 << 30;
    mBox = {openvdb::Coord(-kFar), openvdb::Coord(kFar - 1)};
    std::int64_t low[3], size[3]; // [leaves]
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = box.min()[axis] >> LeafVoxel::kLog2Dim;
        size[axis] = (box.max()[axis] >> LeafVoxel::kLog2Dim) + 1 - low[axis];
    }
    while (ranks > 1) {
        const int axis = int(std::max_element(size, size + 3) - size), half = ranks / 2;
        const std::int64_t before = size[axis] * half / ranks, cut = (low[axis] + before) * LeafVoxel::kDim;
        if (rank < half) {
            mBox.max()[axis] = int(cut) - 1;
            size[axis] = before;
            ranks = half;
        } else {
            mBox.min()[axis] = int(cut);
            low[axis] += before;
            size[axis] -= before;
            rank -= half;
            ranks -= half;
        }
    }
}

bool BoxShare::needs(const openvdb::Coord& origin, int rim) const
{
    const openvdb::Coord last = origin.offsetBy(LeafVoxel::kDim - 1 + rim);
    return mBox.hasOverlap({origin.offsetBy(-rim), last});
}

} // namespace vdblic
