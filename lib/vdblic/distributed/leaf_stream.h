#pragma once

#include "vdblic/io/vdb_assembly.h"

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <string>

namespace vdblic {

/// Leaves on their way from the thread that receives them to the one that writes them. Each side is one thread.
class LeafStream final : public LeafSource {
  public:
    /// @param grids that come through here
    explicit LeafStream(std::size_t grids) : mGrids(grids) {}

    [[nodiscard]] std::size_t grids() const override { return mGrids; }
    StoredLeaves leaves() override; ///< @throws Stopped after giveUp()
    std::string block() override;   ///< @throws Stopped after giveUp()

    /// Begin a grid. @param leaves of it, without blocks
    void begin(StoredLeaves leaves);
    /// Add a block; while too much waits to be written, wait.
    void give(std::string block);
    /// End a grid.
    void end();

    /// Neither side waits for the other any more.
    void giveUp();

  private:
    StoredLeaves take();
    void push(StoredLeaves item);

    std::size_t mGrids;
    std::mutex mMutex;
    std::condition_variable mChanged;
    std::deque<StoredLeaves> mItems; // the lists of a grid, or one block of it; an empty block ends it
    std::size_t mBytes = 0;          // of the blocks in it
    bool mGivenUp = false;
};

} // namespace vdblic
