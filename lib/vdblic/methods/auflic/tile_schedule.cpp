#include "vdblic/methods/auflic/tile_schedule.h"

#include "vdblic/field/leaf_voxel.h"

#include <algorithm>
#include <cstdint>

namespace vdblic {
namespace {

constexpr std::size_t kGroupLeaves = 8; // enough for cheap scheduling, few enough for threads to finish together

} // namespace

TileSchedule::TileSchedule(const Domain& domain, Slabs::Leaves leaves, const openvdb::Coord& reach, std::size_t threads)
    : mApart(2 * reach[0], 2 * reach[1], 2 * reach[2]), mPeriod(domain.period().size >> LeafVoxel::kLog2Dim),
      mCursor(threads), mBusy(threads)
{
    for (std::size_t begin = 0; begin < leaves.size(); begin += kGroupLeaves) {
        Group group{leaves.subspan(begin, std::min(kGroupLeaves, leaves.size() - begin)), {}};
        for (const std::uint32_t leaf : group.leaves) {
            const openvdb::Coord origin = domain.origin(leaf);
            group.box.expand(openvdb::Coord(LeafVoxel::leafCoordinate(origin[0]), LeafVoxel::leafCoordinate(origin[1]),
                                            LeafVoxel::leafCoordinate(origin[2])));
        }
        mGroups.push_back(group);
    }
    mTaken.assign(mGroups.size(), false);
    mLeft = mGroups.size();
    for (std::size_t thread = 0; thread < threads; ++thread) // threads start far from each other
        mCursor[thread] = mGroups.size() * thread / threads;
}

bool TileSchedule::isFree(const Group& group) const
{
    for (const std::optional<std::size_t>& busy : mBusy) {
        if (!busy) continue;
        const openvdb::CoordBBox& other = mGroups[*busy].box;
        bool near = true;
        for (int axis = 0; axis < 3; ++axis) {
            const auto gap = [&](const openvdb::CoordBBox& before, const openvdb::CoordBBox& after) {
                return after.min()[axis] - before.max()[axis];
            };
            const int forth = gap(other, group.box), back = gap(group.box, other);
            const bool isNear = std::max(forth, back) <= mApart[axis];
            const bool isAcross = mPeriod[axis] > 0 && std::min(forth, back) + mPeriod[axis] <= mApart[axis];
            near = near && (isNear || isAcross);
        }
        if (near) return false;
    }
    return true;
}

std::optional<TileSchedule::Group> TileSchedule::next(std::size_t thread)
{
    std::unique_lock lock(mMutex);
    if (mBusy[thread]) {
        mBusy[thread].reset();
        mFreed.notify_all();
    }
    while (mLeft > 0) {
        for (std::size_t i = 0; i < mGroups.size(); ++i) {
            const std::size_t group = (mCursor[thread] + i) % mGroups.size();
            if (mTaken[group] || !isFree(mGroups[group])) continue;
            mTaken[group] = true;
            mBusy[thread] = group;
            mCursor[thread] = group;
            if (--mLeft == 0) mFreed.notify_all();
            return mGroups[group];
        }
        mFreed.wait(lock);
    }
    return std::nullopt;
}

void TileSchedule::stop()
{
    const std::lock_guard lock(mMutex);
    mLeft = 0;
    mFreed.notify_all();
}

} // namespace vdblic
