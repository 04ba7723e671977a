#include "vdblic/lic/frame_halo.h"

#include "vdblic/distributed/velocity_halo.h"
#include "vdblic/field/leaf_voxel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;

/// Let a domain have other local leaves. @param own, local boxes in its index space
void setPart(std::shared_ptr<const Domain>& domain, const openvdb::CoordBBox& own, const openvdb::CoordBBox& local)
{
    if (domain) domain = domain->part(leavesIn(*domain, own), leavesIn(*domain, local));
}

/// @param depth of the halo [texture voxels] @param rim the same for the velocity [its voxels]
void surroundFrame(Exchange& exchange, LoadedFrame& frame, const Coord& depth, const Coord& rim)
{
    const Partition& partition = *frame.partition;
    const openvdb::CoordBBox own = partition.box(exchange.rank()), texture = partition.textureBox(exchange.rank());
    if (Coord::lessThan(frame.rim, rim)) {
        frame.rim.maxComponent(rim);
        addHalo(frame.velocity.values->tree(), exchange, partition, frame.rim);
    }
    setPart(frame.flow.domain, texture, dilated(texture, depth));
    setPart(frame.flow.refinedFrom, own, dilated(own, rim));
}

} // namespace

void keepOwn(LoadedFrame& frame, int rank)
{
    const openvdb::CoordBBox own = frame.partition->box(rank), texture = frame.partition->textureBox(rank);
    if (rank != 0) frame.velocity.carried.clear();
    // A carried grid may be the velocity itself.
    const openvdb::Vec3SGrid::Ptr values =
        frame.velocity.carried.empty() ? frame.velocity.values : frame.velocity.values->deepCopy();
    const auto grid = openvdb::Vec3SGrid::create(takenOut(values->tree(), own));
    grid->insertMeta(*values);
    grid->setTransform(values->transform().copy());
    frame.velocity.values = grid;
    frame.flow.velocities = grid;
    setPart(frame.flow.domain, texture, texture);
    setPart(frame.flow.refinedFrom, own, own);
}

Coord surround(Exchange& exchange, LoadedFrame& start, LoadedFrame& end, const Farthest& farthest)
{
    constexpr int kLeaf = LeafVoxel::kDim, kFewest = 2; // leaves: mean along the flow and sharpening reach one each
    constexpr double kFarAway = 1e6;
    std::array<double, 3> most{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        most[axis] = std::min(double(std::max(farthest.path[axis], farthest.upstream[axis])), kFarAway);
    exchange.max(most);
    Coord depth, rim;
    for (int axis = 0; axis < 3; ++axis) {
        const int factor = start.flow.refinement.factors[std::size_t(axis)];
        // A cell reaches into the next leaf.
        const int leaves = std::max(int(std::ceil(most[std::size_t(axis)] / kLeaf)) + 1, kFewest);
        depth[axis] = leaves * kLeaf;
        rim[axis] = ((leaves + factor - 1) / factor + 1) * kLeaf;
    }
    surroundFrame(exchange, start, depth, rim);
    if (&end != &start) surroundFrame(exchange, end, depth, rim);
    return depth;
}

} // namespace vdblic
