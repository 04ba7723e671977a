#pragma once

#include "vdblic/field/domain_mask.h"
#include "vdblic/flow/velocity_frame.h"
#include "vdblic/io/sequence.h"

#include <optional>

namespace vdblic {

/// A velocity sequence and how to understand it.
struct VelocitySequenceParams {
    SequenceParams input;
    VelocityParams velocity;
    std::optional<double> frameSpacing; ///< seconds between frames on disk; nothing: by metadata, else 1/24
    DomainParams domain;                ///< `worldBox` and `mask` stay in the world, `box` is of the observer's voxels
    ReferenceFrameParams observer{};

    void validate() const; ///< @throws ParameterError
};
/// The parameters of velocity and frame spacing; the sequence, its domain and its observer have their own.
[[nodiscard]] Parameters parametersOf(VelocitySequenceParams& params);

} // namespace vdblic
