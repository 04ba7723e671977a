#include "vdblic/distributed/partition.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace vdblic {
namespace {

constexpr int kFar = 1 << 20; // velocity voxels, beyond every domain

int dividedDown(int number, int by)
{
    return number >= 0 ? number / by : -((-number + by - 1) / by);
}

} // namespace

Partition::Partition(const Domain& velocity, const std::array<int, 3>& factors, int ranks)
    : mFactors(factors), mBoxes(std::size_t(ranks))
{
    std::vector<WeightedLeaf> leaves;
    leaves.reserve(velocity.leafCount());
    for (std::size_t leaf = 0; leaf < velocity.leafCount(); ++leaf) {
        const openvdb::Coord origin = velocity.origin(leaf);
        leaves.push_back({openvdb::Coord(LeafVoxel::leafCoordinate(origin[0]), LeafVoxel::leafCoordinate(origin[1]),
                                         LeafVoxel::leafCoordinate(origin[2])),
                          velocity.mask(leaf).countOn()});
    }
    openvdb::CoordBBox all{openvdb::Coord(-kFar), openvdb::Coord(kFar - 1)};
    const Period& period = velocity.period();
    for (int axis = 0; axis < 3; ++axis) {
        if (period.size[axis] == 0) continue;
        all.min()[axis] = period.first[axis];
        all.max()[axis] = period.first[axis] + period.size[axis] - 1;
    }
    mRoot = build(std::move(leaves), all, 0, ranks);
}

/// @return the number of the node, or −1 − rank
int Partition::build(std::vector<WeightedLeaf> leaves, const openvdb::CoordBBox& box, int firstRank, int ranks)
{
    if (ranks == 1) {
        mBoxes[std::size_t(firstRank)] = {box};
        return -1 - firstRank;
    }
    openvdb::CoordBBox around;
    std::uint64_t voxels = 0;
    for (const WeightedLeaf& leaf : leaves) {
        around.expand(leaf.at);
        voxels += leaf.voxels;
    }
    const int axis = leaves.empty() ? 0 : int(around.maxExtent());
    const int first = leaves.empty() ? 0 : around.min()[axis], layers = leaves.empty() ? 0 : around.dim()[axis];
    const int firstHalf = ranks / 2;

    // The plane nearest to the wanted share. A single layer of leaves is not cut.
    std::vector<std::uint64_t> layer(std::size_t(layers), 0);
    for (const WeightedLeaf& leaf : leaves)
        layer[std::size_t(leaf.at[axis] - first)] += leaf.voxels;
    const std::uint64_t wanted = voxels * std::uint64_t(firstHalf) / std::uint64_t(ranks);
    int cut = layers;
    std::uint64_t before = 0, nearest = ~std::uint64_t(0);
    for (int plane = 1; plane < layers; ++plane) {
        before += layer[std::size_t(plane) - 1];
        const std::uint64_t off = before > wanted ? before - wanted : wanted - before;
        if (off < nearest) {
            nearest = off;
            cut = plane;
        }
    }
    const auto second = std::partition(leaves.begin(), leaves.end(),
                                       [&](const WeightedLeaf& leaf) { return leaf.at[axis] - first < cut; });
    openvdb::CoordBBox boxes[2] = {box, box};
    const int at = (first + cut) * LeafVoxel::kDim;
    boxes[0].max()[axis] = at - 1;
    boxes[1].min()[axis] = at;
    const auto number = mNodes.size();
    mNodes.push_back({axis, at});
    std::vector<WeightedLeaf> others(second, leaves.end());
    leaves.erase(second, leaves.end());
    const int low = build(std::move(leaves), boxes[0], firstRank, firstHalf);
    const int high = build(std::move(others), boxes[1], firstRank + firstHalf, ranks - firstHalf);
    mNodes[number].children[0] = low;
    mNodes[number].children[1] = high;
    return int(number);
}

VoxelBox<Space::kTexture> Partition::textureBox(int rank) const
{
    openvdb::CoordBBox result = box(rank).voxels;
    for (int axis = 0; axis < 3; ++axis) {
        const int factor = mFactors[std::size_t(axis)];
        result.min()[axis] = result.min()[axis] * factor;
        result.max()[axis] = (result.max()[axis] + 1) * factor - 1;
    }
    return {result};
}

double Partition::imbalance(const Domain& velocity) const
{
    std::vector<std::uint64_t> voxels(mBoxes.size(), 0);
    for (std::size_t leaf = 0; leaf < velocity.leafCount(); ++leaf) {
        openvdb::Coord origin = velocity.origin(leaf);
        for (int axis = 0; axis < 3; ++axis)
            origin[axis] *= mFactors[std::size_t(axis)];
        voxels[std::size_t(owner({origin}))] += velocity.mask(leaf).countOn();
    }
    if (velocity.voxelCount() == 0) return 1;
    const std::uint64_t most = *std::max_element(voxels.begin(), voxels.end());
    return double(most) * double(voxels.size()) / double(velocity.voxelCount());
}

int Partition::owner(const Voxel<Space::kTexture>& voxel) const
{
    int node = mRoot;
    while (node >= 0) {
        const Node& here = mNodes[std::size_t(node)];
        const int at = dividedDown(voxel.at[here.axis], mFactors[std::size_t(here.axis)]);
        node = here.children[at >= here.cut];
    }
    return -1 - node;
}

std::vector<std::uint32_t> leavesIn(const Domain& domain, const openvdb::CoordBBox& box)
{
    std::vector<std::uint32_t> leaves;
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf) {
        if (domain.period().isSeenIn(box, domain.origin(leaf))) leaves.push_back(std::uint32_t(leaf));
    }
    return leaves;
}

} // namespace vdblic
