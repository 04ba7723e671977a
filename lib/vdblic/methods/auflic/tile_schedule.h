#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/slabs.h"

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <optional>
#include <vector>

namespace vdblic {

/// Schedules a slab's tiles (TileScatter) so that no two threads write to one leaf at the same time.
///
/// A thread that computes a tile may write to all leaves within `reach`. Two groups of tiles may therefore run together
/// only if they are farther apart than twice the reach along some axis. Thread-safe.
class TileSchedule {
  public:
    /// Tiles for one thread, in order.
    struct Group {
        Slabs::Leaves leaves;
        openvdb::CoordBBox box; ///< of the tiles' coordinates, in leaves
    };

    /// @param leaves must outlive this
    /// @param reach  in leaves, along each axis
    TileSchedule(const Domain& domain, Slabs::Leaves leaves, const openvdb::Coord& reach, std::size_t threads);

    /// The next group for a thread, or nothing if none is left. Ends the thread's previous group. Waits while every
    /// remaining group is too near to a running one. @param thread 0 to threads − 1; each by one thread at a time
    [[nodiscard]] std::optional<Group> next(std::size_t thread);

    /// Hand out no more groups, because a thread failed: threads that wait for its group get nothing.
    void stop();

  private:
    [[nodiscard]] bool isFree(const Group& group) const;

    openvdb::Coord mApart;
    openvdb::Coord mPeriod; // of a periodic box, in leaves; 0 along other axes
    std::vector<Group> mGroups;
    std::vector<bool> mTaken;
    std::vector<std::size_t> mCursor;              // per thread: index of the group to try first
    std::vector<std::optional<std::size_t>> mBusy; // per thread: index of the running group
    std::size_t mLeft;                             // groups still to hand out
    std::mutex mMutex;
    std::condition_variable mFreed;
};

} // namespace vdblic
