#include "vdblic/methods/backward/way_back.h"

#include "vdblic/lic/path_reach.h"

#include <openvdb/openvdb.h>

#include <memory>

namespace vdblic {
namespace {

/// Slabs of two frames together: no leaf of either lies in two slabs.
Slabs slabsOf(const FrameDomain& first, const FrameDomain& last)
{
    const openvdb::MaskTree &before = first.texture->topology(), &after = last.texture->topology();
    if (first.texture == last.texture || before.hasSameTopology(after)) return Slabs(*last.texture, last.refinement);
    const auto both = std::make_shared<openvdb::MaskTree>(before);
    both->topologyUnion(after);
    return Slabs(Domain(both, 1, last.texture->period()), last.refinement);
}

VDBLIC_KERNEL void advanceBack(const VelocityField& field, const Bricks::Window& window, const PathlineParams& params,
                               PathBatch& batch)
{
    advancePaths(field, window, params, batch);
}

/// The position, limited to kFarthest from another one.
VDBLIC_INLINE Float8 within(Float8 position, Float8 from)
{
    const Float8 way = position - from,
                 farthest = way < 0 ? broadcast8(-WayBack::kFarthest) : broadcast8(WayBack::kFarthest);
    const Int8 isNear = (way >= -WayBack::kFarthest) & (way <= WayBack::kFarthest);
    return isNear ? position : from + farthest;
}
VDBLIC_INLINE Vector8 within(const Vector8& positions, const Vector8& from)
{
    return {within(positions.x, from.x), within(positions.y, from.y), within(positions.z, from.z)};
}

} // namespace

VelocityField WayBack::reversed(const FlowStep& step)
{
    VelocityField field;
    field.prepare(step.end.domain, step.endVelocities() * -1.0, step.startVelocities() * -1.0);
    return field;
}

WayBack::WayBack(const FlowStep& step, const PathlineParams& params)
    : mParams(params), mField(reversed(step)), mSlabs(slabsOf(step.start.domain, step.end.domain)),
      mFirstSlabs(mSlabs, *step.start.domain.texture, {}), mLastSlabs(mSlabs, *step.end.domain.texture, {}),
      mVelocitySlabs(mSlabs, *mField.sampledDomain().velocity, mField.sampledDomain().refinement)
{
    const Refinement& sampled = mField.sampledDomain().refinement;
    const auto finer = float(sampled.factors[std::size_t(mSlabs.axis())] - 1);
    mReach = leavesReached(longestPath(mField.largest()[std::size_t(mSlabs.axis())]) + finer);
}

void WayBack::Leaf::follow(Row& row, unsigned lanes) const
{
    mBatch.lanes = lanes;
    mBatch.position = row.centre;
    mBatch.slope = row.slope;
    advanceBack(mWay.mField, mWindow, mWay.mParams, mBatch);
    Float8 left = broadcast8(1); // part of the step after the last segment
    for (const Segment& segment : mBatch.segments)
        left = maskOf(segment.lanes) ? 1 - (segment.time + segment.duration) : left;
    left = maskOf(mBatch.arrived) ? Float8{} : left;
    row.before = select(maskOf(lanes), within(mBatch.position + mBatch.slope * left, row.centre), row.before);
    row.slope = select(maskOf(lanes), within(row.slope, Vector8{}), row.slope);
}

} // namespace vdblic
