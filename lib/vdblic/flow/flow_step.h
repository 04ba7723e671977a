#pragma once

#include "vdblic/field/leaf_owners.h"
#include "vdblic/field/velocities.h"
#include "vdblic/flow/velocity_frame.h"

namespace vdblic {

/// A time step: the time between two frames or, with substeps, a part of it. It has one texture.
struct FlowStep {
    const VelocityFrame& start;
    const VelocityFrame& end;
    double interval = 1;                   ///< seconds between the frames on disk around the step
    int substeps = 1;                      ///< steps in the interval
    int substep = 0;                       ///< number of this step in the interval
    double time = 0;                       ///< seconds, at the start
    const LeafOwners& owners = kSoleOwner; ///< of the leaves of the first frame's domain
    const FlowStep* whole = nullptr;       ///< the whole interval; null if the step is the whole
    bool isShown = true;                   ///< whether its texture is written; else the step only prepares later ones
    bool withHits = false;                 ///< whether to return TextureFrame::hits; for methods that scatter

    [[nodiscard]] double seconds() const { return interval / substeps; }

    using Velocity = Velocities<Space::kVelocity, Per::kStep>;
    [[nodiscard]] Velocity startVelocities() const { return velocitiesOf(start); }
    [[nodiscard]] Velocity endVelocities() const { return velocitiesOf(end); }

  private:
    [[nodiscard]] Velocity velocitiesOf(const VelocityFrame& frame) const
    {
        const Domain* const domain = frame.domain.velocity.get(); // null as read from a file
        return {frame.values->tree(),
                {frame.toVoxelsPerFrame(interval).matrix * (1.0 / substeps)},
                domain ? domain->period() : Period{}};
    }
};

} // namespace vdblic
