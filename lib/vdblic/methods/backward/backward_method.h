#pragma once

#include "vdblic/methods/method_params.h"

namespace vdblic {

/// \file
/// Common parts of TextureMethod for all methods that look back.

/// Frames until a blended texture no longer shows its start.
[[nodiscard]] int settlingFrames(const MethodParams& params);

/// The life span and the share of noise.
void describeBlended(const MethodParams& params, openvdb::MetaMap& metadata);

/// Memory [bytes]. @param carried floats per voxel between frames  @param brick bytes per leaf of them
/// @param velocity, texture voxels of their leaves
[[nodiscard]] double backwardBytes(double carried, double brick, double velocity, double texture);

/// TextureMethod::bytes from an estimate.
template<const TextureMethod::Estimate& kEstimate>
double bytesByEstimate(const MethodParams& /*params*/, const FrameDomain& first, const Refinement& /*given*/,
                       bool /*withHits*/)
{
    return kEstimate.bytes(double(first.velocity->local().size()) * Domain::kLeafVoxels,
                           double(first.texture->local().size()) * Domain::kLeafVoxels);
}

} // namespace vdblic
