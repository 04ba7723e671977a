#pragma once

#include <openvdb/openvdb.h>

namespace vdblic {

/// A grid's values at the active voxels of another; the transforms may differ.
///
/// Trilinear over the active ones of the eight corners, with weights normalised to 1; a voxel without such a corner is
/// 0. Name, class and other metadata are those of `values`. Computed in parallel; the result does not depend on the
/// number of threads.
/// @param like its active voxels and transform; both transforms must be linear
[[nodiscard]] openvdb::FloatGrid::Ptr resampled(const openvdb::FloatGrid& values, const openvdb::FloatGrid& like);

} // namespace vdblic
