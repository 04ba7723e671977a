#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/lic/pathline_params.h"
#include "vdblic/lic/stage_clock.h"
#include "vdblic/methods/flow_texture.h"
#include "vdblic/noise/noise_field.h"

#include <cstdint>

namespace vdblic {

/// A particle in each voxel of a domain. It moves with the fluid and keeps its value of noise: the carried values of
/// LEA and UFAC. Jobard, Erlebacher & Hussaini, "Lagrangian-Eulerian advection of noise and dye textures for unsteady
/// flow visualization", TVCG 8(3), 2002.
///
/// A step looks back from a voxel's centre along the pathline. The particle in the unit cube there, the closest to its
/// middle if there are several, moves into the voxel; the offset at which it arrives is kept. So values move without
/// blur, and slow fluid moves them too.
///
/// Where fluid is stretched, no particle arrives in some voxels: they repeat the closest one's value, a voxel away from
/// it. A share of them gets a new value instead, else the noise would coarsen. Entering fluid brings new noise.
struct CellParticles {
    static constexpr float kWhite = 65535;     ///< the largest value
    static constexpr int kOffsetEnd = 1 << 24; ///< larger than any offset

    LeafValues<float> values;
    LeafValues<std::int32_t> offsets; ///< from the voxel's centre, packed; 0 where there is no voxel

    /// One particle at the centre of each voxel of a domain's own leaves, with the noise's value.
    [[nodiscard]] static CellParticles centred(const Domain& domain, const NoiseField& noise);

    /// The particles at the end of a step, on its second frame's own leaves.
    /// @param this at the step's start, halo included  @param number of the step
    [[nodiscard]] CellParticles moved(const FlowStep& step, const NoiseField& noise, std::uint64_t number,
                                      const PathlineParams& pathline, StageClock& clock) const;
};

} // namespace vdblic
