#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/flow/velocity_frame.h"
#include "vdblic/methods/flow_texture.h"
#include "vdblic/methods/texture_params.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace vdblic::test {

/// Velocity in voxels per step at a voxel and a frame; nothing for a voxel outside the domain.
using FlowFunction = std::function<std::optional<openvdb::Vec3f>(const openvdb::Coord&, int frame)>;

/// Frames of a flow on a box of index space, in voxels per step.
std::vector<VelocityFrame> makeFrames(const openvdb::CoordBBox& box, int frames, const FlowFunction& flow);

/// The same frames, to be computed on finer voxels.
std::vector<VelocityFrame> refined(std::vector<VelocityFrame> frames, const Refinement& refinement);

/// The step from frame k to frame k + 1.
FlowStep stepFrom(const std::vector<VelocityFrame>& frames, std::size_t k);

/// A turning, drifting, unsteady flow with a hole in a box that does not start at the origin; the hole moves.
std::vector<VelocityFrame> unsteadyFlowWithHole(int frames);

/// The textures of the library's pipeline for the first `steps` steps.
std::vector<LeafValues<float>> streamedTextures(const std::vector<VelocityFrame>& frames, int steps,
                                                const TextureParams& scatter);

/// The state of a texture whose method has one.
TextureMemory& memoryOf(FlowTexture& texture);

} // namespace vdblic::test
