#pragma once

#include "vdblic/lines/lines.h"

#include <openvdb/openvdb.h>

#include <array>
#include <span>
#include <string_view>
#include <vector>

namespace vdblic {

/// \file
/// Lines as OpenVDB points (docs/formats.md): a grid kLineGrid with a point for each point of a line, in the velocity's
/// index space. Its attributes have Houdini's names where there are any.

inline constexpr const char* kLineGrid = "streaks";

inline constexpr const char* kLineAge = "age"; ///< attribute of Lines::ages

/// The attributes that every grid of lines has, except `source`, which it has if a line has a source.
inline constexpr auto kLineAttributes =
    std::to_array<std::string_view>({"P", "id", "order", "pscale", "Alpha", kLineAge, "source"});

/// The grid of lines. Positions have 16 bits a coordinate within a voxel; scalars are halfs, or floats if the largest
/// magnitude is outside 1/16 to 65504. Computed in parallel; the bytes do not depend on the number of threads.
/// @param transform of the velocity
/// @param scalars  whose values at the points the grid has too, by valuesAt()
[[nodiscard]] openvdb::GridBase::Ptr lineGrid(const Lines& lines, const openvdb::math::Transform& transform,
                                              std::span<const openvdb::FloatGrid::Ptr> scalars = {});

/// The lines of a grid, in ascending order of their ids.
/// @throws InputError, without the file's name, if an attribute is missing or of another type, a value other than a
///         scalar's is not finite, or the points of a line are not numbered from 0 on
[[nodiscard]] Lines linesOf(const openvdb::GridBase& grid);

/// A scalar at points, trilinear: the weighted mean of the finite values around a point, NaN without one.
/// Computed in parallel.
/// @param transform of the index space of the points
[[nodiscard]] std::vector<float> valuesAt(const openvdb::FloatGrid& scalar, std::span<const openvdb::Vec3f> points,
                                          const openvdb::math::Transform& transform);

} // namespace vdblic
