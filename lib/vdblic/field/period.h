#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>

namespace vdblic {

/// A box whose contents repeat along some axes of an index space, so that what leaves it on one side enters it on the
/// other. Along such an axis the box begins with a leaf, and its size is a whole number of leaves.
struct Period {
    openvdb::Coord first{0}; ///< voxel of the box
    openvdb::Coord size{0};  ///< [voxels]; 0 along axes without repetition

    [[nodiscard]] bool isNone() const { return size == openvdb::Coord(0); }

    /// The voxel of the box that an image shows; along other axes unchanged.
    [[nodiscard]] openvdb::Coord wrapped(const openvdb::Coord& voxel) const
    {
        openvdb::Coord result;
        for (int axis = 0; axis < 3; ++axis)
            result[axis] = after(first[axis], voxel[axis], axis);
        return result;
    }

    /// Whether a voxel or one of its images lies in another box.
    [[nodiscard]] bool isSeenIn(const openvdb::CoordBBox& box, const openvdb::Coord& voxel) const
    {
        openvdb::Coord image = voxel;
        for (int axis = 0; axis < 3; ++axis)
            image[axis] = after(box.min()[axis], voxel[axis], axis);
        return box.isInside(image);
    }

    /// Whether a box overlaps with another or with one of its images.
    [[nodiscard]] bool overlap(const openvdb::CoordBBox& a, const openvdb::CoordBBox& b) const
    {
        for (int axis = 0; axis < 3; ++axis) {
            const bool isBehind = after(a.min()[axis], b.min()[axis], axis) > a.max()[axis],
                       isBefore = after(b.min()[axis], a.min()[axis], axis) > b.max()[axis];
            if (size[axis] == 0 ? isBehind || isBefore : isBehind && isBefore) return false;
        }
        return true;
    }

    bool operator==(const Period&) const = default;

  private:
    /// The first image of a coordinate from another one on; the coordinate itself along axes without repetition.
    [[nodiscard]] int after(int begin, int coordinate, int axis) const
    {
        if (size[axis] == 0) return coordinate;
        const auto from = (std::int64_t(coordinate) - begin) % size[axis]; // of the sign of the dividend
        return int(from < 0 ? from + size[axis] : from) + begin;
    }
};

} // namespace vdblic
