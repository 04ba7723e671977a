#pragma once

#include "vdblic/methods/texture_method.h"

namespace vdblic {

/// Values that particles scatter along their pathlines, and a filter that feeds each texture forward to the next step.
///
/// Shen & Kao, "A new line integral convolution algorithm for visualizing time-varying flow fields", TVCG 4(2), 1998
/// (UFLIC). Liu & Moorhead, "AUFLIC: an accelerated algorithm for unsteady flow line integral convolution", VisSym
/// 2002, and "Visualizing time-varying three-dimensional flow fields using accelerated UFLIC", 2004. Differences from
/// these: docs/algorithm.md.
extern const TextureMethod kAuflic;     ///< accelerated, with history
extern const TextureMethod kAuflic2004; ///< accelerated, as published
extern const TextureMethod kUflic;      ///< a seed for every voxel and frame

} // namespace vdblic
