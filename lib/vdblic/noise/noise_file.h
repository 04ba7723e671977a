#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/field/box_domain.h"
#include "vdblic/field/refinement.h"

#include <openvdb/openvdb.h>

#include <cstdint>
#include <optional>
#include <string>

namespace vdblic {

/// Parameters of a file of noise. Exactly one of `like` and `size` must be given.
struct NoiseParams {
    std::string output;
    std::string like;            ///< FILE or FILE:GRID that gives active voxels and transform
    std::optional<BoxSize> size; ///< voxels of a box, with voxels of kDefaultVoxelSize
    Refinement refinement{};     ///< of the voxels of `like`
    std::uint32_t seed = 1;
    bool skipExisting = false; ///< keep an existing output

    /// @throws ParameterError
    void validate() const;
};
[[nodiscard]] Parameters parametersOf(NoiseParams& params);

/// Write the noise of makeNoise() as the one grid of a file.
///
/// Without a grid's name `like` means the file's first grid with active voxels. Voxels and transform are those of a
/// texture with that refinement: the file is the noise that such a texture starts from.
/// @throws ParameterError, InputError if `like` has no such grid, OutputError
void makeNoiseFile(const NoiseParams& params, Reporter& reporter);

/// Read the initial noise. @param argument FILE, which means its grid `noise`, or FILE:GRID
/// @throws InputError if there is no such float grid or a value is outside 0 to 1
[[nodiscard]] openvdb::FloatGrid::ConstPtr readNoise(const std::string& argument);

} // namespace vdblic
