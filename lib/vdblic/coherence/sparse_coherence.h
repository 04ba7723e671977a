#pragma once

#include "vdblic/coherence/coherence_params.h"
#include "vdblic/coherence/sparse_figures.h"
#include "vdblic/field/domain.h"
#include "vdblic/field/refinement.h"

#include <openvdb/openvdb.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

namespace vdblic {

class VelocityField;

/// A texture whose inactive voxels are empty.
struct SparseTexture {
    openvdb::FloatTree::ConstPtr values;
    std::shared_ptr<const Domain> domain;          ///< its active voxels
    Refinement refinement;                         ///< of the velocity's voxels
    std::optional<std::array<float, 3>> spacing{}; ///< between streaks [voxels of the velocity]
};

/// Measure a sparse texture against its successor and the velocity between them.
///
/// Points are chosen by a hash, uniformly over active voxels. One counts where the texture is above 0.15, so that it
/// can be seen, and the flow moves by a texture voxel or more in the step. Downstream is a texture voxel along the
/// velocity; values are trilinear. A tail is the path of its head: in a steady flow it moves with the flow, and in an
/// unsteady one it stays and fades. So a voxel vanishes if the successor has half of its value neither in the 27 voxels
/// around it nor in the 27 around the end of its pathline. It appears by the same rule against time. Pathlines that
/// leave the domain do not count.
///
/// A head is a local maximum with a tail upstream and at most a quarter of its value a quarter of a spacing downstream.
/// The brightest of several within 0.3 spacings counts; heads that fade in or out do not. So heads are located to a
/// voxel, and some are false: the low percentiles of their distances are lower bounds.
///
/// @param next     the successor; null if there is none
/// @param forward  velocity over the step, on the velocity's own voxels, in voxels of the velocity per step
/// @param backward velocity against time, from the successor's time on; null if there is no successor
/// Computed in parallel; the result is bit-identical for any number of threads. @throws ParameterError
[[nodiscard]] SparseCoherence measureSparse(const SparseTexture& texture, const SparseTexture* next,
                                            const VelocityField& forward, const VelocityField* backward,
                                            const CoherenceParams& params, std::int64_t frame);

} // namespace vdblic
