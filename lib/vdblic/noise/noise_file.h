#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/field/box_domain.h"
#include "vdblic/field/refinement.h"

#include <openvdb/openvdb.h>

#include <cstdint>
#include <optional>
#include <string>

namespace vdblic {

/// How to make a file of noise. Exactly one of `like` and `size` must be given.
struct NoiseParams {
    std::string output;
    std::string like;            ///< FILE or FILE:GRID whose active voxels and transform to take
    std::optional<BoxSize> size; ///< voxels of a box, with voxels of kDefaultVoxelSize
    Refinement refinement{};     ///< of the voxels of `like`
    std::uint32_t seed = 1;
    bool skipExisting = false; ///< keep an output that exists

    /// @throws ParameterError
    void validate() const;
};
[[nodiscard]] Parameters parametersOf(NoiseParams& params);

/// Write the noise of makeNoise() as the one grid of a file.
///
/// If `like` names no grid, the first grid of the file that has active voxels is taken. The voxels and the transform
/// are those of a texture with that refinement, so this is the noise that such a texture starts from.
/// @throws ParameterError, InputError if `like` has no such grid, OutputError
void makeNoiseFile(const NoiseParams& params, Reporter& reporter);

/// Read noise to start from. @param argument FILE, which means its grid `noise`, or FILE:GRID
/// @throws InputError if there is no such float grid or a value is outside 0 to 1
[[nodiscard]] openvdb::FloatGrid::ConstPtr readNoise(const std::string& argument);

} // namespace vdblic
