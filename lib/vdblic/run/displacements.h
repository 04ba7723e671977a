#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

class Exchange;
struct VelocityFrame;

/// How far voxels move from a frame to the next [voxels of the velocity], over frames. Counts add up to the same for
/// any number of threads.
class Displacements {
  public:
    /// Count a frame's active voxels, in parallel. @param interval seconds between frames
    void add(const VelocityFrame& frame, double interval);
    /// Sum the counts of all ranks; collective.
    void join(Exchange& exchange);

    /// The displacement of the faster half of the flow: half of all motion is of voxels that move at least so far, to a
    /// hundredth. Still voxels around a flow and single fast ones do not change it much. 0 if nothing moves.
    [[nodiscard]] double ofFasterHalf() const;

  private:
    // Squares are counted by the sign-free upper bits of a float: 32 steps between two powers of two.
    static constexpr int kDroppedBits = 18;
    static constexpr std::size_t kSteps = 0x7f800000u >> kDroppedBits; // below infinity
    using Counts = std::vector<std::uint64_t>; // not an array: there is one for each task, and stacks may be small

    Counts mCounts = Counts(kSteps);
};

} // namespace vdblic
