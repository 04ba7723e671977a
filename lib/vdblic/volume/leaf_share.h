#pragma once

#include <openvdb/openvdb.h>

namespace vdblic {

/// The leaves of a frame that one of several ranks has. Every leaf is owned by one rank; others may need it, too.
/// Any number of threads may read.
class LeafShare {
  public:
    explicit LeafShare(int ranks) : mRanks(ranks) {}
    LeafShare(const LeafShare&) = default;
    LeafShare& operator=(const LeafShare&) = default;
    virtual ~LeafShare() = default;

    [[nodiscard]] int ranks() const { return mRanks; }

    /// Whether the rank owns a leaf. @param origin its first voxel
    [[nodiscard]] virtual bool owns(const openvdb::Coord& origin) const = 0;
    /// Whether a leaf is less than so many voxels from one that the rank owns or shows.
    [[nodiscard]] virtual bool needs(const openvdb::Coord& origin, int rim) const = 0;

  private:
    int mRanks;
};

/// The leaves in one of the boxes into which a volume is cut, across its longest axes.
class BoxShare final : public LeafShare {
  public:
    /// @param bounds of the active voxels; what lies outside has owners too
    BoxShare(const openvdb::CoordBBox& bounds, int rank, int ranks);

    [[nodiscard]] bool owns(const openvdb::Coord& origin) const override { return mBox.isInside(origin); }
    [[nodiscard]] bool needs(const openvdb::Coord& origin, int rim) const override;

  private:
    openvdb::CoordBBox mBox; // whole leaves
};

} // namespace vdblic
