#pragma once

#include "vdblic/flow/velocity_frame.h"

#include <array>
#include <memory>

namespace vdblic {

/// Replace a frame by what an observer sees of it: velocity and carried grids move to the observer's space. The voxels
/// of carried grids stay as they are.
/// @param frame   in a unit per second
/// @param seconds since the observer's start
/// @param part    of the observer's voxels; other leaves get no values
/// @throws InputError if a carried grid has vectors, the observer turns, and textures stay with it
void observe(VelocityFrame& frame, std::shared_ptr<const ReferenceFrame> observer, double seconds,
             const std::optional<VelocityPart>& part);

/// The part of the world's voxels from which observe() makes a part of the observer's.
[[nodiscard]] VelocityPart partSeen(const VelocityPart& part, const ReferenceFrame& observer, double seconds);

/// Convert a frame to a unit per second. @param interval seconds between frames on disk
void makePerSecond(VelocityFrame& frame, double interval);

/// The mean velocity of the active voxels [world units per second], to six digits of its largest component.
[[nodiscard]] std::array<double, 3> meanVelocity(const VelocityFrame& frame);

} // namespace vdblic
