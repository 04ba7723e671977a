#pragma once

#include "vdblic/render/transfer_params.h"

#include <filesystem>

namespace vdblic {

/// Read a transfer function from a JSON file: an object with any of
///
///     "range":    [LOW, HIGH]                               values of the driver at positions 0 and 1
///     "colormap": "viridis"                                 a named colour map, or instead
///     "colors":   [[POSITION, RED, GREEN, BLUE], ...]       display (sRGB) values, 0 to 1
///     "opacity":  [[POSITION, OPACITY], ...]                of one voxel
///
/// by rising position from 0 to 1. Keys that are left out keep their values in `params`.
/// @throws InputError naming the file and the error
void readTransferFile(const std::filesystem::path& path, TransferParams& params);

/// Write all keys of a transfer function, as writeReport() does. @param params with range and opacity
/// @throws OutputError
bool writeTransferFile(const std::filesystem::path& path, const TransferParams& params);

} // namespace vdblic
