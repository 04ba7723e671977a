#pragma once

#include "vdblic/field/box_domain.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/flow/velocity_frame.h"
#include "vdblic/methods/flow_texture.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <memory>
#include <string>
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

/// The analytic flow `abc` in a box, sampled on a domain, 24 frames a second.
[[nodiscard]] Flow analyticFlow(const BoxSize& size, int frames, const std::shared_ptr<const Domain>& domain);

/// Read a velocity sequence. @param range a frame list
[[nodiscard]] Flow flowOfFiles(const std::string& pattern, const std::string& range);

} // namespace vdblic::bench
