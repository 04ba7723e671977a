#pragma once

#include "vdblic/compare/compare.h"

#include <openvdb/openvdb.h>

#include <optional>
#include <string>
#include <vector>

namespace vdblic::compare {

/// The metadata that is not the same, by name, without the ignored.
///
/// The same number in another numeric type is the same.
[[nodiscard]] std::vector<MetadataDifference> compareMetadata(const openvdb::MetaMap& a, const openvdb::MetaMap& b,
                                                              const std::vector<std::string>& ignored);

/// Nothing if no corner of the active voxels of both grids is moved further than the tolerance [voxels].
[[nodiscard]] std::optional<TransformDifference> compareTransforms(const openvdb::GridBase& a,
                                                                   const openvdb::GridBase& b, double tolerance);

} // namespace vdblic::compare
