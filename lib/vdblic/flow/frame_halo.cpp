#include "vdblic/flow/frame_halo.h"

#include "vdblic/distributed/velocity_halo.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/velocity_field.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;

/// Replace a domain's local leaves. @param own, local boxes in its index space
template<Space kSpace>
void setPart(std::shared_ptr<const Domain>& domain, const VoxelBox<kSpace>& own, const VoxelBox<kSpace>& local)
{
    if (domain) domain = domain->ofRank(leavesIn(*domain, own.voxels), leavesIn(*domain, local.voxels));
}

/// Reduce a frame to a rank's own part.
void keepPart(VelocityFrame& frame, int rank, openvdb::Vec3SGrid& values)
{
    const VoxelBox<Space::kVelocity> own = frame.partition->box(rank);
    const VoxelBox<Space::kTexture> texture = frame.partition->textureBox(rank);
    const auto grid = openvdb::Vec3SGrid::create(takenOut(values.tree(), own));
    grid->insertMeta(values);
    grid->setTransform(values.transform().copy());
    frame.values = grid;
    frame.rims.clear();
    frame.largest = largestSpeeds(grid->tree());
    setPart(frame.domain.texture, texture, texture);
    setPart(frame.domain.velocity, own, own);
}

constexpr int kLeaf = LeafVoxel::kDim, kFewest = 2; // leaves: one each for the mean along the flow and for sharpening

/// The depth of a halo that contains paths of a given length. @param farthest along each axis [texture voxels]
Rim<Space::kTexture> depthFor(const std::array<double, 3>& farthest)
{
    constexpr double kFarAway = 1e6;
    Coord depth;
    for (int axis = 0; axis < 3; ++axis) { // A cell reaches into the next leaf.
        const double leaves = std::ceil(std::min(farthest[std::size_t(axis)], kFarAway) / kLeaf) + 1;
        depth[axis] = std::max(int(leaves), kFewest) * kLeaf;
    }
    return {depth};
}

} // namespace

void keepOwn(VelocityFrame& frame, int rank)
{
    if (rank != 0) frame.carried.clear();
    // A carried grid may be the velocity itself.
    const openvdb::Vec3SGrid::Ptr values = frame.carried.empty() ? frame.values : frame.values->deepCopy();
    keepPart(frame, rank, *values);
}

void handOver(Exchange& exchange, VelocityFrame& frame, std::shared_ptr<const Partition> partition)
{
    std::vector<VoxelBox<Space::kVelocity>> boxes;
    for (int rank = 0; rank < exchange.size(); ++rank)
        boxes.push_back(partition->box(rank));
    const openvdb::Vec3SGrid::Ptr values = frame.values;
    addParts(values->tree(), exchange, *frame.partition, boxes, {});
    frame.partition = std::move(partition);
    keepPart(frame, exchange.rank(), *values);
}

std::vector<Rim<Space::kTexture>> haloDepths(Exchange& exchange, const Partition& partition, const Farthest& farthest,
                                             const Period& period)
{
    const auto ranks = std::size_t(partition.ranks()), mine = std::size_t(exchange.rank());
    std::vector<double> paths(3 * ranks, 0); // along three axes, from each rank's voxels
    for (std::size_t axis = 0; axis < 3; ++axis)
        paths[3 * mine + axis] = std::max(farthest.path[axis], farthest.upstream[axis]);
    exchange.max(paths);

    Rim<Space::kTexture> depth;
    for (Rim<Space::kTexture> next = depthFor({}); next.voxels != depth.voxels;) {
        depth = next;
        const VoxelBox<Space::kTexture> around = dilated(partition.textureBox(int(mine)), depth);
        std::array<double, 3> most{};
        for (std::size_t rank = 0; rank < ranks; ++rank) {
            if (!period.overlap(around.voxels, partition.textureBox(int(rank)).voxels)) continue;
            for (std::size_t axis = 0; axis < 3; ++axis)
                most[axis] = std::max(most[axis], paths[3 * rank + axis]);
        }
        next = depthFor(most);
    }

    std::vector<double> shared(3 * ranks, 0);
    for (std::size_t axis = 0; axis < 3; ++axis)
        shared[3 * mine + axis] = depth.voxels[int(axis)];
    exchange.max(shared);
    std::vector<Rim<Space::kTexture>> depths;
    for (std::size_t rank = 0; rank < ranks; ++rank)
        depths.push_back({{int(shared[3 * rank]), int(shared[3 * rank + 1]), int(shared[3 * rank + 2])}});
    return depths;
}

void surround(Exchange& exchange, VelocityFrame& frame, const std::vector<Rim<Space::kTexture>>& depths)
{
    const Partition& partition = *frame.partition;
    const auto mine = std::size_t(exchange.rank());
    frame.rims.resize(depths.size());
    bool isDeeper = false; // at any rank
    for (std::size_t rank = 0; rank < depths.size(); ++rank) {
        Coord rim;
        for (int axis = 0; axis < 3; ++axis) {
            const int factor = frame.domain.refinement.factors[std::size_t(axis)];
            rim[axis] = ((depths[rank].voxels[axis] / kLeaf + factor - 1) / factor + 1) * kLeaf;
        }
        Coord& known = frame.rims[rank].voxels;
        isDeeper = isDeeper || Coord::lessThan(known, rim);
        known.maxComponent(rim);
    }
    if (isDeeper) {
        std::vector<VoxelBox<Space::kVelocity>> boxes;
        for (std::size_t rank = 0; rank < depths.size(); ++rank)
            boxes.push_back(dilated(partition.box(int(rank)), frame.rims[rank]));
        addParts(frame.values->tree(), exchange, partition, boxes, frame.domain.velocity->period());
    }
    const VoxelBox<Space::kVelocity> own = partition.box(int(mine));
    const VoxelBox<Space::kTexture> texture = partition.textureBox(int(mine));
    setPart(frame.domain.texture, texture, dilated(texture, depths[mine]));
    setPart(frame.domain.velocity, own, dilated(own, frame.rims[mine]));
}

} // namespace vdblic
