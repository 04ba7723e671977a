#pragma once

#include "vdblic/field/box_domain.h"

#include <openvdb/openvdb.h>

#include <functional>
#include <span>
#include <string_view>

namespace vdblic {

/// A velocity given by a formula: a pure function of position and time. Any number of threads may call it.
using FlowFunction = std::function<openvdb::Vec3d(const openvdb::Vec3d& position, double time)>;

/// An unsteady flow in a box, without units.
///
/// A flow is made for a box whose sides are `extent`, with the middle one of the three sides as the unit of length,
/// so that it suits slabs as well as long boxes. Positions count from the box's centre. The unit of time is the one
/// in which the flow's typical speed is 1.
struct AnalyticFlow {
    std::string_view name, description;
    FlowFunction (*make)(const openvdb::Vec3d& extent);
};

/// Every flow there is.
[[nodiscard]] std::span<const AnalyticFlow> analyticFlows();

/// @throws ParameterError naming the flows there are
[[nodiscard]] const AnalyticFlow& findAnalyticFlow(std::string_view name);

/// The typical speed of a flow in a box of voxels, in voxels per second: three voxels a frame at 24 frames a second.
inline constexpr double kFlowSpeed = 72;

/// A flow in the world: position in world units, time in seconds → velocity in world units per second.
///
/// The flow is scaled to the box: its unit of length is the middle one of the box's sides, its typical speed kFlowSpeed
/// voxels per second whatever the size is. So a larger box holds the same flow at a higher resolution, and the
/// flow takes longer to change.
///
/// @param voxelSize in world units; the centre of voxel (i, j, k) lies at (i, j, k) · voxelSize
/// @throws ParameterError as checkBoxSize() does, or if the voxel size is not a positive number
[[nodiscard]] FlowFunction flowInBox(const AnalyticFlow& flow, const BoxSize& size, double voxelSize);

} // namespace vdblic
