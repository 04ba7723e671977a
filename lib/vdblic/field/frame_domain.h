#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/refinement.h"

#include <memory>
#include <utility>

namespace vdblic {

/// The voxels of a frame: the texture's, and the velocity voxels around them. Both are the same without refinement.
struct FrameDomain {
    std::shared_ptr<const Domain> texture, velocity;
    Refinement refinement;

    FrameDomain() = default;
    FrameDomain(std::shared_ptr<const Domain> both) : texture(std::move(both)), velocity(texture) {}
    FrameDomain(std::shared_ptr<const Domain> ofTexture, std::shared_ptr<const Domain> ofVelocity,
                const Refinement& factors)
        : texture(std::move(ofTexture)), velocity(std::move(ofVelocity)), refinement(factors)
    {
    }
};

} // namespace vdblic
