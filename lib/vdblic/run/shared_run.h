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
    /// Of the faster half of the whole frame's flow (Displacements); collective.
    [[nodiscard]] double fasterDisplacement(const VelocityFrame& frame, double interval) const;

    /// Cut a frame's domain anew, once a step is made, and hand over its parts and the texture's state, if the ranks'
    /// shares of it have become so unequal that this pays. @return whether that was done, as a text
    [[nodiscard]] std::optional<std::string> balance(VelocityFrame& frame, FlowTexture& texture);

    /// Receive the halo that steps between two frames need.
    /// @param seconds between the frames  @param texture that makes the steps
    void surround(VelocityFrame& start, VelocityFrame& end, double seconds, const FlowTexture& texture);

    /// The owners of a frame's leaves in a step that starts from it; its surroundings must be there.
    [[nodiscard]] std::unique_ptr<const LeafOwners> ownersOf(const VelocityFrame& start) const;

    /// Store the leaves of a frame's grids that this rank computed, for FrameWriter::write(). Not collective.
    /// @param isWriter whether this rank writes the file: its grids then get all leaves, without values
    [[nodiscard]] std::vector<OwnLeaves> store(const VelocityFrame& frame, TextureFile& file, bool isWriter) const;

  private:
    const AdvectPlan& mPlan;
    Exchange& mExchange;
    double mLeastImbalance = 1;                // that the last attempt to cut anew found possible
    std::vector<Rim<Space::kTexture>> mDepths; // of the ranks' halos
};

} // namespace vdblic
