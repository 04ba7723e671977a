#pragma once

#include "vdblic/look/shading.h"
#include "vdblic/look/transfer_params.h"

#include <optional>

namespace vdblic {

/// The parameters of a picture's look. chooseLook() chooses the unset values.
struct LookParams {
    TransferParams transfer;
    double textureStrength = 1; ///< of the modulation of opacity by texture, 0 to 1
    double limbDarkening = 1;   ///< of the modulation of colour by texture, 0 to 1
    Shading shading;
    double opticalDepth = 3; ///< of a path through the volume, where opacity is chosen automatically
    double halo = 0;         ///< strength of halos, at least 0
    double depthCue = 0;     ///< share of the background in the colour of the farthest sample, 0 to 1

    double shadows = 0;               ///< share of the light that full shadow takes away, 0 to 1
    double occlusion = 0;             ///< strength of ambient occlusion, 0 to 1
    std::optional<double> exposure{}; ///< of the picture [stops]: its light times 2^exposure

    /// @throws ParameterError
    void validate() const;
};
[[nodiscard]] Parameters parametersOf(LookParams& params);

} // namespace vdblic
