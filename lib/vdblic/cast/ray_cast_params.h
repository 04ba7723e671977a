#pragma once

#include "vdblic/camera/clipping.h"
#include "vdblic/field/refinement.h"

#include <optional>

namespace vdblic {

/// How rays are sampled.
struct RayCastParams {
    double step = 1;                              ///< between samples [voxels along the ray, in index space]
    std::optional<Interpolation> interpolation{}; ///< of the texture between its voxels; unset: linear
    /// A ray ends once its transmittance is below this. Samples that add less than this share to their ray's alpha are
    /// shaded together, at the position of the last of them.
    double leastTransmittance = 1.0 / 256;
    ClipParams clip{};
    bool layers = false; ///< whether to compute the image's layers

    [[nodiscard]] bool isCubic() const { return interpolation == Interpolation::kCubic; }

    /// @throws ParameterError
    void validate() const;
};

[[nodiscard]] Parameters parametersOf(RayCastParams& params);

} // namespace vdblic
