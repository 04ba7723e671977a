#pragma once

#include <cstddef>

namespace vdblic {

struct AdvectParams;
struct FieldDomain;

/// The memory that a run takes at its peak [bytes], by its first frame. Fitted to measured runs: within a quarter of
/// them for domains of full leaves (docs/reports/performance.md).
[[nodiscard]] double advectBytes(const AdvectParams& params, const FieldDomain& first);

/// The same for a run with default parameters. @param voxels of the velocity's leaves
[[nodiscard]] double advectBytes(double voxels);

} // namespace vdblic
