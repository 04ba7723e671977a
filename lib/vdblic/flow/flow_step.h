#pragma once

#include "vdblic/field/leaf_owners.h"
#include "vdblic/field/velocities.h"
#include "vdblic/flow/velocity_frame.h"

namespace vdblic {

/// The time between two frames, or with substeps a part of it, in which a texture is made.
struct FlowStep {
    const VelocityFrame& start;
    const VelocityFrame& end;
    double interval = 1;                   ///< seconds between the frames on disk around the step
    int substeps = 1;                      ///< steps in that interval
    int substep = 0;                       ///< number of this one
    double time = 0;                       ///< seconds, at the start
    const LeafOwners& owners = kSoleOwner; ///< of the leaves of the first frame's domain
    const FlowStep* whole = nullptr;       ///< the interval that the step is a part of; null if it is all of it
    bool isShown = true;                   ///< whether its texture is written, and does not only prepare others
    bool withHits = false;                 ///< whether TextureFrame::hits is asked for; of methods that scatter

    [[nodiscard]] double seconds() const { return interval / substeps; }

    using Velocity = Velocities<Space::kVelocity, Per::kStep>;
    [[nodiscard]] Velocity startVelocities() const { return velocitiesOf(start); }
    [[nodiscard]] Velocity endVelocities() const { return velocitiesOf(end); }

  private:
    [[nodiscard]] Velocity velocitiesOf(const VelocityFrame& frame) const
    {
        return {frame.values->tree(), {frame.toVoxelsPerFrame(interval).matrix * (1.0 / substeps)}};
    }
};

} // namespace vdblic
