#pragma once

#include "vdblic/field/frame_domain.h"
#include "vdblic/io/sequence.h"

#include <openvdb/openvdb.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdblic {

/// The part of the velocity's active voxels to compute on.
struct DomainParams {
    /// FILE or FILE:GRID, where FILE is one file or a sequence with the input's frame numbers; empty for all voxels.
    /// A voxel is included if, at its centre, the mask is positive (a level set: negative; a mask grid: active).
    std::string mask;
    std::optional<std::array<int, 6>> box;         ///< first and last voxel of the velocity, x y z x y z
    std::optional<std::array<double, 6>> worldBox; ///< lower and upper corner; a voxel is included by its centre
    /// Axes, x, y and z, along which the velocity repeats: its active voxels in `box` are one period.
    std::vector<std::string> periodic{};
    Refinement refinement{}; ///< of the computed voxels; `mask` and `worldBox` select refined voxels

    void validate() const; ///< @throws ParameterError
};
[[nodiscard]] Parameters parametersOf(DomainParams& params);
/// The parameter `periodic`. @param axes DomainParams::periodic
[[nodiscard]] Parameter periodicParameter(std::vector<std::string>& axes);

/// The domain of a frame: the velocity's active voxels, refined and cut by the parameters.
///
/// @param topology the velocity's active voxels and tiles; only tiles inside the boxes are expanded
/// @param transform of the velocity; the mask may have another
/// @param ranks that share the voxels
/// @throws InputError if the mask cannot be read, its type is not supported, the voxels exceed the memory, or the
///         periodic box does not consist of whole leaves
[[nodiscard]] FrameDomain makeDomain(openvdb::MaskTree::Ptr topology, const openvdb::math::Transform& transform,
                                     const DomainParams& params, std::int64_t frame, int ranks = 1);

} // namespace vdblic
