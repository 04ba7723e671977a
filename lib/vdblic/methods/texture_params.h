#pragma once

#include "vdblic/lic/pathline_params.h"
#include "vdblic/methods/auflic/auflic.h"
#include "vdblic/methods/auflic/feedback_params.h"

namespace vdblic {

/// Parameters of textures.
///
/// With substeps every voxel still has one seed a frame, released in a substep that differs from tile to tile, and
/// values live as many frames: the work of a step and the memory do not grow with the substeps.
struct TextureParams {
    const TextureMethod* method = &kAuflic; ///< never null
    int lifeSpan =
        4; ///< frames over which a seed scatters its value; AUFLIC's fade at that pace; of LIC and UFAC the kernel's
    static constexpr int kMostSubsteps = 256;
    int substeps = 1;            ///< time steps per frame
    float releaseWindow = 0.25f; ///< AUFLIC: part of a frame, from its start, in which seeds may be released
    PathlineParams pathline;
    FeedbackParams feedback;

    /// Half the kernel along streamlines [steps]: streaks are then as long as UFLIC's in a steady flow.
    [[nodiscard]] double kernelHalf() const { return 0.5 * lifeSpan * substeps; }

    void validate() const; ///< @throws ParameterError
};
[[nodiscard]] Parameters parametersOf(TextureParams& params);

} // namespace vdblic
