#pragma once

#include "vdblic/look/transfer_params.h"

#include <filesystem>

namespace vdblic {

/// Read a transfer function from a JSON file: an object with any of
///
///     "range":         [LOW, HIGH]                           values at positions 0 and 1 of the scalar that colours
///     "unit":          "m/s"                                 of that scalar
///     "colormap":      "viridis"                             a named colour map, or instead
///     "colors":        [[POSITION, RED, GREEN, BLUE], ...]   display (sRGB) values, 0 to 1
///     "opacity":       [[POSITION, OPACITY], ...]            of one voxel
///     "opacity_range": [LOW, HIGH]                           as range, of the scalar that opacity follows
///     "opacity_unit":  "1/s²"                                of that scalar
///     "color_scale":   "linear" or "log"                     how values are spread over positions, and
///     "opacity_scale": "linear" or "log"                     the same of the scalar that opacity follows
///
/// by rising position from 0 to 1. Keys that are left out keep their values in `params`.
/// @throws InputError naming the file and the error
void readTransferFile(const std::filesystem::path& path, TransferParams& params);

/// Write all keys of a transfer function, as writeReport() does. @param params with range and opacity
/// @throws OutputError
bool writeTransferFile(const std::filesystem::path& path, const TransferParams& params);

} // namespace vdblic
