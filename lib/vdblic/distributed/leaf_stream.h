#pragma once

#include "vdblic/io/vdb_assembly.h"

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <string>

namespace vdblic {

/// A queue of leaves between the receiving and the writing thread, one of each.
class LeafStream final : public LeafSource {
  public:
    /// @param grids number of grids to pass
    explicit LeafStream(std::size_t grids) : mGrids(grids) {}

    [[nodiscard]] std::size_t grids() const override { return mGrids; }
    StoredLeaves leaves() override; ///< @throws Stopped after giveUp()
    std::string block() override;   ///< @throws Stopped after giveUp()

    /// Begin a grid. @param leaves its list, without blocks
    void begin(StoredLeaves leaves);
    /// Add a block; wait while too many bytes are queued.
    void give(std::string block);
    /// End a grid.
    void end();

    /// Release both sides from waiting.
    void giveUp();

  private:
    StoredLeaves take();
    void push(StoredLeaves item);

    std::size_t mGrids;
    std::mutex mMutex;
    std::condition_variable mChanged;
    std::deque<StoredLeaves> mItems; // a grid's list, or a block; an empty block ends the grid
    std::size_t mBytes = 0;          // of the queued blocks
    bool mGivenUp = false;
};

} // namespace vdblic
