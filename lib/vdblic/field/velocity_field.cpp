#include "vdblic/field/velocity_field.h"

#include "vdblic/core/stopwatch.h"
#include "vdblic/field/cubic_brick.h"
#include "vdblic/field/largest_value.h"

#include <cmath>
#include <cstddef>
#include <utility>

namespace vdblic {
namespace {

VDBLIC_INLINE Float4 larger(Float4 a, Float4 b)
{
    return a > b ? a : b;
}

/// Set four numbers of each record of a leaf's brick to the velocity and its coverage.
/// @param origin of the leaf  @param lane the first of the four
VDBLIC_KERNEL void fillLevel(const VelocityLevel& level, const openvdb::Coord& origin, Record* records, int lane)
{
    const openvdb::Mat3s m(level.toStep);
    const Float4 x = {m(0, 0), m(1, 0), m(2, 0), 0}, y = {m(0, 1), m(1, 1), m(2, 1), 0},
                 z = {m(0, 2), m(1, 2), m(2, 2), 0}, covered = {0, 0, 0, 1};
    visitBrick(level.velocities, origin, [&](int record, const openvdb::Vec3f& value, bool active) {
        const Float4 step = x * value[0] + y * value[1] + z * value[2] + covered;
        *reinterpret_cast<Float4*>(records[record].values + lane) = active ? step : Float4{};
    });
}

} // namespace

Float4 largestMagnitude(const openvdb::Vec3STree& values)
{
    struct Amount { // as a template argument, a vector type alone would lose its alignment
        Float4 lanes{};
    };
    const auto amount = [](const openvdb::Vec3f& value) {
        const Float4 v = {value[0], value[1], value[2], 0};
        return Amount{v < 0 ? -v : v};
    };
    return largestValue(values, Amount{}, amount,
                        [](const Amount& a, const Amount& b) { return Amount{larger(a.lanes, b.lanes)}; })
        .lanes;
}

Float4 largestVelocity(Float4 magnitude, const openvdb::Mat3d& toStep)
{
    Float4 most{};
    for (int to = 0; to < 3; ++to) {
        for (int from = 0; from < 3; ++from)
            most[to] += float(std::abs(toStep(to, from))) * magnitude[from];
    }
    return most;
}

void VelocityField::prepare(FieldDomain domain, const VelocityLevel& start, const VelocityLevel& end)
{
    Stopwatch watch;
    mDomain = std::move(domain);
    const Refinement& refinement = mDomain.refinement;
    mSampled = refinement.interpolation == Interpolation::kCubic ? FieldDomain(mDomain.texture) : mDomain;
    for (int axis = 0; axis < 3; ++axis) {
        mScale[axis] = mSampled.refinement.scale(axis);
        mShift[axis] = mSampled.refinement.shift(axis);
    }
    const openvdb::Mat3d toTexture = refinement.toTexture();
    mStart.emplace(VelocityLevel{start.velocities, toTexture * start.toStep});
    mEnd.emplace(VelocityLevel{end.velocities, toTexture * end.toStep});
    mBricks.cover(mSampled.velocity);
    mLargest = larger(largestVelocity(largestMagnitude(mStart->velocities), mStart->toStep),
                      largestVelocity(largestMagnitude(mEnd->velocities), mEnd->toStep));
    mSeconds = watch.lap();
}

void VelocityField::fill(Slabs::Leaves leaves)
{
    Stopwatch watch;
    mBricks.fill(leaves, [&](std::size_t leaf, Record* records) {
        if (mDomain.refinement.interpolation == Interpolation::kCubic) {
            CubicBrick brick(mDomain.refinement, mSampled.velocity->origin(leaf));
            brick.fill(*mStart, records, 0);
            brick.fill(*mEnd, records, 4);
            return;
        }
        const openvdb::Coord origin = mDomain.velocity->origin(leaf);
        fillLevel(*mStart, origin, records, 0);
        fillLevel(*mEnd, origin, records, 4);
    });
    mSeconds += watch.lap();
}

void VelocityField::build(FieldDomain domain, const VelocityLevel& start, const VelocityLevel& end)
{
    prepare(std::move(domain), start, end);
    fill(mSampled.velocity->local());
}

} // namespace vdblic
