#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/distributed/leaf_delivery.h"
#include "vdblic/field/leaf_owners.h"
#include "vdblic/field/units.h"
#include "vdblic/flow/velocity_sequence.h"
#include "vdblic/run/texture_file.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdblic {

struct AdvectPlan;
class FlowTexture;

/// Exchange between the ranks of a run, frame by frame. All functions but store() are collective, and do nothing
/// for a process alone. Not thread-safe.
class SharedRun {
  public:
    /// Both must outlive this.
    SharedRun(const AdvectPlan& plan, Exchange& exchange) : mPlan(plan), mExchange(exchange) {}

    /// Check that all ranks read the same frame. @param stamp of the frame, empty if there is none. @throws InputError
    void checkSame(const std::string& stamp) const;

    /// The largest displacement from a frame to the next, at any rank [voxels]. @param interval seconds between them
    [[nodiscard]] double largestDisplacement(const VelocityFrame& frame, double interval) const;
    /// The displacement of the whole frame's faster half (Displacements); collective.
    [[nodiscard]] double fasterDisplacement(const VelocityFrame& frame, double interval) const;

    /// Partition a frame anew after a step, and hand over its parts and the texture's state, if the imbalance of the
    /// ranks makes this worthwhile. @return a text if it was done
    [[nodiscard]] std::optional<std::string> balance(VelocityFrame& frame, FlowTexture& texture);

    /// Receive the halo for the steps between two frames.
    /// @param seconds between the frames  @param texture that computes the steps
    void surround(VelocityFrame& start, VelocityFrame& end, double seconds, const FlowTexture& texture);

    /// The owners of a frame's leaves in a step that starts from it; requires surround().
    [[nodiscard]] std::unique_ptr<const LeafOwners> ownersOf(const VelocityFrame& start) const;

    /// Store the leaves of a frame's grids that this rank computed, for FrameWriter::write(). Not collective.
    /// @param isWriter whether this rank writes the file: its grids then get all leaves, without values
    [[nodiscard]] std::vector<OwnLeaves> store(const VelocityFrame& frame, TextureFile& file, bool isWriter) const;

  private:
    const AdvectPlan& mPlan;
    Exchange& mExchange;
    double mLeastImbalance = 1;                // lowest imbalance possible at the last attempt
    std::vector<Rim<Space::kTexture>> mDepths; // of the ranks' halos
};

} // namespace vdblic
