#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/units.h"

#include <openvdb/openvdb.h>

#include <array>
#include <cstdint>
#include <vector>

namespace vdblic {

/// The parts of index space owned by the ranks: boxes with faces between leaves of the velocity. The outer faces are
/// far away, or those of a periodic box, so every voxel of any domain has one owner. Immutable; any number of threads
/// may read.
///
/// Recursive coordinate bisection: Berger & Bokhari, "A partitioning strategy for nonuniform problems on
/// multiprocessors", IEEE Transactions on Computers C-36, 1987. Every rank computes the same cuts.
class Partition {
  public:
    /// Cut a domain into parts of about equally many voxels, across the longest axis of each part.
    /// @param factors texture voxels in a velocity voxel, along each axis
    Partition(const Domain& velocity, const std::array<int, 3>& factors, int ranks);

    [[nodiscard]] int ranks() const { return int(mBoxes.size()); }
    [[nodiscard]] const std::array<int, 3>& factors() const { return mFactors; }

    /// A rank's box, in voxels of the velocity and of the texture.
    [[nodiscard]] const VoxelBox<Space::kVelocity>& box(int rank) const { return mBoxes[std::size_t(rank)]; }
    [[nodiscard]] VoxelBox<Space::kTexture> textureBox(int rank) const;

    /// The most voxels of a rank over the mean of all ranks; 1 for an empty domain.
    [[nodiscard]] double imbalance(const Domain& velocity) const;

    /// The rank that owns a voxel.
    [[nodiscard]] int owner(const Voxel<Space::kTexture>& voxel) const;

  private:
    struct WeightedLeaf {
        openvdb::Coord at; // in leaves
        std::uint64_t voxels;
    };
    struct Node {
        int axis, cut;            // the first voxel after the cut
        int children[2] = {0, 0}; // a node's number, or −1 − rank
    };

    int build(std::vector<WeightedLeaf> leaves, const openvdb::CoordBBox& box, int firstRank, int ranks);

    std::array<int, 3> mFactors;
    std::vector<VoxelBox<Space::kVelocity>> mBoxes;
    std::vector<Node> mNodes;
    int mRoot = -1;
};

/// A box with a rim.
template<Space kSpace>
[[nodiscard]] VoxelBox<kSpace> dilated(const VoxelBox<kSpace>& box, const Rim<kSpace>& rim)
{
    return {{box.voxels.min() - rim.voxels, box.voxels.max() + rim.voxels}};
}

/// The leaves of a domain whose first voxels, or images of these in a periodic box, lie in a box of its index space,
/// ascending.
[[nodiscard]] std::vector<std::uint32_t> leavesIn(const Domain& domain, const openvdb::CoordBBox& box);

} // namespace vdblic
