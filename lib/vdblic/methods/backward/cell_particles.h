#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/lic/pathline_params.h"
#include "vdblic/lic/stage_clock.h"
#include "vdblic/methods/flow_texture.h"
#include "vdblic/noise/noise_field.h"

#include <cstdint>

namespace vdblic {

/// A particle in each voxel of a domain, with a value of noise that it keeps as it moves with the fluid: what LEA and
/// UFAC carry. Jobard, Erlebacher & Hussaini, "Lagrangian-Eulerian advection of noise and dye textures for unsteady
/// flow visualization", TVCG 8(3), 2002.
///
/// A step looks back from a voxel's centre along the pathline. The particle that is carried into the voxel is the one
/// that lay in the unit cube there, the closest to the middle if there are several; where in the voxel it arrives is
/// kept. So values move without blur, and slow fluid moves them, too.
///
/// Where fluid is stretched, no particle arrives in some voxels: the value of the closest one is repeated, a voxel away
/// from it. A part of those voxels has a new value of noise, else noise would become coarse. Entering fluid brings new
/// noise.
struct CellParticles {
    static constexpr float kWhite = 65535;     ///< the largest value
    static constexpr int kOffsetEnd = 1 << 24; ///< no offset is as large

    LeafValues<float> values;
    LeafValues<std::int32_t> offsets; ///< from the voxel's centre, packed; 0 where there is no voxel

    /// One in the centre of each voxel of a domain's own leaves, with the noise's value.
    [[nodiscard]] static CellParticles centred(const Domain& domain, const NoiseField& noise);

    /// At the end of a step, on its second frame's own leaves.
    /// @param this at the step's start, halo included  @param number of the step
    [[nodiscard]] CellParticles moved(const FlowStep& step, const NoiseField& noise, std::uint64_t number,
                                      const PathlineParams& pathline, StageClock& clock) const;
};

} // namespace vdblic
