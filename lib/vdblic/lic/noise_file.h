#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/field/box_domain.h"

#include <cstdint>
#include <optional>
#include <string>

namespace vdblic {

/// How to make a file of noise. Exactly one of `like` and `size` is given.
struct NoiseParams {
    std::string output;
    std::string like;            ///< FILE or FILE:GRID whose active voxels and transform to take
    std::optional<BoxSize> size; ///< voxels of a box, with voxels of kDefaultVoxelSize
    std::uint32_t seed = 1;
    bool skipExisting = false; ///< leave an output that is there as it is

    /// @throws ParameterError
    void validate() const;
};

/// Write the noise of makeNoise() as the one grid of a file.
///
/// Without a grid's name, `like` means the first grid in the file that has active voxels.
/// @throws ParameterError, InputError if `like` has no such grid, OutputError
void makeNoiseFile(const NoiseParams& params, Reporter& reporter);

} // namespace vdblic
