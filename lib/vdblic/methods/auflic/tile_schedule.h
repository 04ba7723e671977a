#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/slabs.h"

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <optional>
#include <vector>

namespace vdblic {

/// Hands a slab's tiles (TileScatter) out to threads so that no two threads write to one leaf at the same time.
///
/// A thread that computes a tile may write to all leaves within `reach` of it. Two groups of tiles may therefore be
/// computed together only if they are farther apart than twice the reach along some axis. Thread-safe.
class TileSchedule {
  public:
    /// Tiles that one thread computes, one after the other.
    struct Group {
        Slabs::Leaves leaves;
        openvdb::CoordBBox box; ///< of the tiles' coordinates, in leaves
    };

    /// @param leaves must outlive this
    /// @param reach  in leaves, along each axis
    TileSchedule(const Domain& domain, Slabs::Leaves leaves, const openvdb::Coord& reach, std::size_t threads);

    /// The next group for a thread, or nothing if none is left. Ends the thread's group before. Waits while every group
    /// left is too near to one being computed.
    /// @param thread 0 to threads − 1; each by one thread at a time
    [[nodiscard]] std::optional<Group> next(std::size_t thread);

    /// Hand out no more groups, because a thread failed: threads that wait for its group get nothing.
    void stop();

  private:
    [[nodiscard]] bool isFree(const Group& group) const;

    openvdb::Coord mApart;
    std::vector<Group> mGroups;
    std::vector<bool> mTaken;
    std::vector<std::size_t> mCursor;              // of each thread: index of the group to look at first
    std::vector<std::optional<std::size_t>> mBusy; // of each thread: index of the group being computed
    std::size_t mLeft;                             // groups not handed out yet
    std::mutex mMutex;
    std::condition_variable mFreed;
};

} // namespace vdblic
