#pragma once

#include "vdblic/field/box_domain.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/flow/velocity_frame.h"
#include "vdblic/methods/flow_texture.h"

#include <cstddef>
#include <vector>

namespace vdblic::bench {

/// A flow held in memory.
struct Flow {
    std::vector<VelocityFrame> frames;
    double interval = 1; ///< seconds between frames

    [[nodiscard]] std::size_t steps() const { return frames.size() - 1; }
    [[nodiscard]] FlowStep step(std::size_t k) const { return {frames[k], frames[k + 1], interval}; }
    void build(std::size_t k, VelocityField& field) const
    {
        field.build(frames[k].domain, step(k).startVelocities(), step(k).endVelocities());
    }
};

/// The analytic flow `abc` in a full box, 24 frames a second.
[[nodiscard]] Flow analyticFlow(const BoxSize& size, int frames);

} // namespace vdblic::bench
