#pragma once

#include "vdblic/field/box_domain.h"

#include <openvdb/openvdb.h>

#include <functional>
#include <span>
#include <string_view>

namespace vdblic {

/// A velocity given by a formula: a pure function of position and time. Any number of threads may call it.
using FlowFunction = std::function<openvdb::Vec3d(const openvdb::Vec3d& position, double time)>;

/// An unsteady flow: in a box, without units, or on a globe, in the units of globe.h.
///
/// In a box `make` takes the box's sides in units of their median, so that flows suit slabs as well as long boxes.
/// Positions are relative to the box's centre. The unit of time is such that the typical speed is 1.
/// On a globe the extent is of no account.
struct AnalyticFlow {
    std::string_view name, description;
    FlowFunction (*make)(const openvdb::Vec3d& extent);
    bool isOnGlobe = false;
};

/// All flows.
[[nodiscard]] std::span<const AnalyticFlow> analyticFlows();

/// The flow of a name. @throws ParameterError naming the known flows
[[nodiscard]] const AnalyticFlow& findAnalyticFlow(std::string_view name);

/// The typical speed of a flow in a box of voxels, in voxels per second: three voxels a frame at 24 frames a second.
inline constexpr double kFlowSpeed = 72;

/// A flow in the world: position in world units, time in seconds → velocity in world units per second.
///
/// The flow is scaled to the box: its unit of length is the median of the box's sides, its typical speed kFlowSpeed
/// voxels per second for any size. So a larger box has the same flow at a higher resolution, and the flow changes more
/// slowly.
///
/// @param voxelSize in world units; the centre of voxel (i, j, k) lies at (i, j, k) · voxelSize
/// @throws ParameterError of checkBoxSize() and checkVoxelSize(), or if the flow is on a globe
[[nodiscard]] FlowFunction flowInBox(const AnalyticFlow& flow, const BoxSize& size, double voxelSize);

} // namespace vdblic
