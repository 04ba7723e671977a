#pragma once

#include "vdblic/camera/clipping.h"

namespace vdblic {

/// How rays are sampled.
struct RayCastParams {
    double step = 0.5; ///< between samples [voxels along the ray, in index space]
    /// A ray ends once its transmittance is below this. Samples that add less than this share to their ray's alpha are
    /// shaded together, at the position of the last of them.
    double leastTransmittance = 1.0 / 256;
    ClipParams clip{};
    bool layers = false; ///< whether the image gets layers too

    /// @throws ParameterError
    void validate() const;
};

[[nodiscard]] Parameters parametersOf(RayCastParams& params);

} // namespace vdblic
