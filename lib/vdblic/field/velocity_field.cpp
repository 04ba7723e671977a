#include "vdblic/field/velocity_field.h"

#include "vdblic/field/cubic_brick.h"
#include "vdblic/field/largest_value.h"
#include "vdblic/field/velocity_leaf.h"

#include <cstddef>
#include <utility>

namespace vdblic {
namespace {

using PerStep = Velocities<Space::kTexture, Per::kStep>;

/// Set the records of a leaf's brick to the velocities at the step's two ends, each with its coverage.
/// @param origin of the leaf
VDBLIC_KERNEL void fillBrick(const PerStep& start, const PerStep& end, const openvdb::Coord& origin, Record* records)
{
    constexpr int kDim = LeafVoxel::kDim;
    VelocityLeaf starts[2][2][2], ends[2][2][2]; // the leaf and its successors
    for (int i = 0; i < 8; ++i) {
        const int x = i >> 2, y = i >> 1 & 1, z = i & 1;
        const openvdb::Coord there = origin.offsetBy(kDim * x, kDim * y, kDim * z);
        starts[x][y][z] = VelocityLeaf(start, there);
        ends[x][y][z] = VelocityLeaf(end, there);
    }
    for (int x = 0; x <= kDim; ++x) {
        for (int y = 0; y <= kDim; ++y) {
            const int i = LeafVoxel::leafCoordinate(x), j = LeafVoxel::leafCoordinate(y), row = LeafVoxel::row(x, y);
            Record* const to = records + Bricks::index(x, y, 0);
            Float8 rows[kDim]; // columns at first
            const auto setColumns = [&](const VelocityLeaf& leaf, Float8* columns) {
                const VelocityLeaf::Row values = leaf.row(row);
                columns[0] = values.velocities.x;
                columns[1] = values.velocities.y;
                columns[2] = values.velocities.z;
                columns[3] = values.active ? broadcast8(1) : Float8{};
            };
            setColumns(starts[i][j][0], rows);
            setColumns(ends[i][j][0], rows + 4);
            transpose(rows, rows);
            __builtin_memcpy(to, &rows, sizeof rows);
            const Float4 last[2] = {starts[i][j][1].first(row), ends[i][j][1].first(row)};
            __builtin_memcpy(to + kDim, &last, sizeof last);
        }
    }
}

} // namespace

StoredSpeeds largestSpeeds(const openvdb::Vec3STree& values)
{
    const auto magnitude = [](Float8 v) { return v < 0 ? -v : v; };
    const Vector8 most = largestValues(values, [&](const Vector8& value) {
        return Vector8{magnitude(value.x), magnitude(value.y), magnitude(value.z)};
    });
    return {{largestLane(most.x), largestLane(most.y), largestLane(most.z)}};
}

void VelocityField::prepare(FrameDomain domain, const Velocities<Space::kVelocity, Per::kStep>& start,
                            const Velocities<Space::kVelocity, Per::kStep>& end)
{
    mDomain = std::move(domain);
    const Refinement& refinement = mDomain.refinement;
    mSampled = refinement.interpolation == Interpolation::kCubic ? FrameDomain(mDomain.texture) : mDomain;
    for (int axis = 0; axis < 3; ++axis) {
        mScale[axis] = mSampled.refinement.scale(axis);
        mShift[axis] = mSampled.refinement.shift(axis);
    }
    mStart.emplace(refinement.toTexture(start));
    mEnd.emplace(refinement.toTexture(end));
    mBricks.cover(mSampled.velocity);
    mLargest = larger(largestSpeeds(largestSpeeds(mStart->stored), mStart->unit),
                      largestSpeeds(largestSpeeds(mEnd->stored), mEnd->unit));
}

void VelocityField::fill(Slabs::Leaves leaves)
{
    mBricks.fill(leaves, [&](std::size_t leaf, Record* records) {
        if (mDomain.refinement.interpolation == Interpolation::kCubic) {
            CubicBrick brick(mDomain.refinement, mSampled.velocity->origin(leaf));
            brick.fill(*mStart, records, 0);
            brick.fill(*mEnd, records, 4);
            return;
        }
        fillBrick(*mStart, *mEnd, mDomain.velocity->origin(leaf), records);
    });
}

void VelocityField::build(FrameDomain domain, const Velocities<Space::kVelocity, Per::kStep>& start,
                          const Velocities<Space::kVelocity, Per::kStep>& end)
{
    prepare(std::move(domain), start, end);
    fill(mSampled.velocity->local());
}

} // namespace vdblic
