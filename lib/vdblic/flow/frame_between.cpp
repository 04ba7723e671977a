#include "vdblic/flow/frame_between.h"

#include "vdblic/core/paging.h"

#include <openvdb/tree/LeafManager.h>

#include <cstddef>
#include <memory>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;
using openvdb::Vec3STree;
using Values = openvdb::tree::ValueAccessor<const Vec3STree>;

/// Interpolates between two trees where both are active; elsewhere uses the active one.
class ValuesBetween {
  public:
    ValuesBetween(const Vec3STree& before, const Vec3STree& after, const openvdb::Mat3s& unit, float fraction)
        : mBefore(before), mAfter(after), mUnit(unit), mFraction(fraction)
    {
    }

    /// One of the trees must be active at the voxel.
    [[nodiscard]] Vec3f at(const Coord& voxel)
    {
        Vec3f before, after;
        const bool hasBefore = mBefore.probeValue(voxel, before), hasAfter = mAfter.probeValue(voxel, after);
        after = mUnit * after;
        if (!hasAfter) return before;
        return hasBefore ? before + (after - before) * mFraction : after;
    }

  private:
    Values mBefore, mAfter;
    openvdb::Mat3s mUnit; // from the second tree's unit to the first's
    float mFraction;
};

/// Matrix from the stored unit of one frame to the stored unit of another.
openvdb::Mat3s unitChange(const VelocityFrame& from, const VelocityFrame& to)
{
    if (from.unit == to.unit && from.scale == to.scale) return openvdb::Mat3s::identity();
    return openvdb::Mat3s(to.toVoxelsPerFrame(1).matrix.inverse() * from.toVoxelsPerFrame(1).matrix);
}

} // namespace

VelocityFrame frameBetween(const VelocityFrame& before, const VelocityFrame& after, double fraction)
{
    const Vec3STree &first = before.values->tree(), &second = after.values->tree();
    const ValuesBetween between(first, second, unitChange(after, before), float(fraction));
    auto tree = std::make_shared<Vec3STree>(first, Vec3f(0), openvdb::TopologyCopy());
    tree->topologyUnion(second);
    openvdb::tree::LeafManager<Vec3STree> leaves(*tree);
    leaves.foreach ([&](Vec3STree::LeafNodeType& leaf, std::size_t) {
        paging::breathe(paging::kLeafBytes);
        ValuesBetween values = between;
        for (auto voxel = leaf.beginValueOn(); voxel; ++voxel)
            voxel.setValue(values.at(voxel.getCoord()));
    });
    ValuesBetween values = between;
    auto tile = tree->beginValueOn();
    tile.setMaxDepth(tile.getLeafDepth() - 1);
    for (; tile; ++tile)
        tile.setValue(values.at(tile.getCoord()));

    VelocityFrame frame = before;
    frame.sourceFrame += (after.sourceFrame - before.sourceFrame) * fraction;
    frame.observedSeconds += (after.observedSeconds - before.observedSeconds) * fraction;
    frame.readSeconds = 0;
    frame.values = openvdb::Vec3SGrid::create(tree);
    frame.values->setTransform(before.values->transform().copy());
    return frame;
}

} // namespace vdblic
