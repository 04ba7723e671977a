#pragma once

#include "vdblic/render/transfer_function.h"

#include <filesystem>

namespace vdblic {

/// Read a transfer function from a JSON file: an object with any of
///
///     "range":    [LOW, HIGH]                               magnitudes at positions 0 and 1
///     "colormap": "viridis"                                 a named colour map, or instead
///     "colors":   [[POSITION, RED, GREEN, BLUE], ...]       colours as displayed, 0 to 1
///     "opacity":  [[POSITION, OPACITY], ...]                of one voxel
///
/// by rising position from 0 to 1. What it leaves out stays as it is in `params`.
/// @throws InputError naming the file and what is wrong with it
void readTransferFile(const std::filesystem::path& path, TransferParams& params);

} // namespace vdblic
