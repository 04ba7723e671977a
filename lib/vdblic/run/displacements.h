#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

class Exchange;
struct VelocityFrame;

/// Histogram of displacements between frames [velocity voxels], over several frames. Counts are the same for any number
/// of threads.
class Displacements {
  public:
    /// Count a frame's active voxels, in parallel. @param interval seconds between frames
    void add(const VelocityFrame& frame, double interval);
    /// Sum the counts of all ranks; collective.
    void join(Exchange& exchange);

    /// The displacement d of the flow's faster half, to a hundredth: half of all motion is of voxels that move at least
    /// d. Still voxels around a flow and single fast ones hardly change it. 0 without motion.
    [[nodiscard]] double ofFasterHalf() const;

  private:
    // Bins are the upper bits of a squared displacement as a float: 32 between two powers of two.
    static constexpr int kDroppedBits = 18;
    static constexpr std::size_t kSteps = 0x7f800000u >> kDroppedBits; // below infinity
    using Counts = std::vector<std::uint64_t>; // no array: each task has one, and stacks may be small

    Counts mCounts = Counts(kSteps);
};

} // namespace vdblic
