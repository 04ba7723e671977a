#pragma once

#include "vdblic/field/slabs.h"

#include <condition_variable>
#include <mutex>
#include <optional>
#include <vector>

namespace vdblic {

/// Hands out a slab's leaves to threads so that no two of them write to the same leaf at the same time.
///
/// A thread at work on a leaf may write to all leaves within `reach` of it, so two groups of leaves can be at work
/// together only if twice the reach lies between them. Thread-safe.
class TileSchedule {
  public:
    /// Leaves that one thread works on, one after the other.
    struct Group {
        Slabs::Leaves leaves;
        openvdb::CoordBBox box; ///< of their places, in leaves
    };

    /// @param leaves must outlive this
    /// @param reach  in leaves, along each axis
    TileSchedule(const Domain& domain, Slabs::Leaves leaves, const openvdb::Coord& reach, std::size_t threads);

    /// The next group for a thread, numbered from 0, which is done with the one before; nothing if none is left. Waits
    /// while all that are left are too near to those at work.
    [[nodiscard]] std::optional<Group> next(std::size_t thread);

  private:
    [[nodiscard]] bool isFree(const Group& group) const;

    openvdb::Coord mApart;
    std::vector<Group> mGroups;
    std::vector<bool> mTaken;
    std::vector<std::size_t> mCursor;              // of each thread: where it goes on to look
    std::vector<std::optional<std::size_t>> mBusy; // of each thread: the group at work
    std::size_t mLeft;
    std::mutex mMutex;
    std::condition_variable mFreed;
};

} // namespace vdblic
