#pragma once

#include "vdblic/compare/compare.h"

#include <openvdb/openvdb.h>

#include <optional>
#include <string>
#include <vector>

namespace vdblic::compare {

/// The metadata entries that differ, sorted by name.
///
/// Equal numbers of different numeric types are equal. Numbers with a fraction are equal within a billionth of the
/// larger one, in single precision a millionth.
/// @param ignored names to skip; a final `*` matches any ending
[[nodiscard]] std::vector<MetadataDifference> compareMetadata(const openvdb::MetaMap& a, const openvdb::MetaMap& b,
                                                              const std::vector<std::string>& ignored);

/// The difference of two transforms; none if it moves no corner of the active voxels' bounding box by more than the
/// tolerance [voxels].
[[nodiscard]] std::optional<TransformDifference> compareTransforms(const openvdb::GridBase& a,
                                                                   const openvdb::GridBase& b, double tolerance);

} // namespace vdblic::compare
