#pragma once

#include "vdblic/field/field_domain.h"

#include <openvdb/openvdb.h>

#include <memory>

namespace vdblic {

/// One frame of the flow: its domain, and its velocity.
struct FlowFrame {
    std::shared_ptr<const Domain> domain; ///< of the texture
    openvdb::Vec3SGrid::ConstPtr velocities;

    // Of a texture with other voxels than the velocity:
    Refinement refinement{};
    std::shared_ptr<const Domain> refinedFrom{}; ///< the velocity's voxels under `domain`; null if not refined

    [[nodiscard]] const std::shared_ptr<const Domain>& velocityDomain() const
    {
        return refinedFrom ? refinedFrom : domain;
    }
    [[nodiscard]] FieldDomain fieldDomain() const { return {domain, velocityDomain(), refinement}; }
};

} // namespace vdblic
