#include "vdblic/methods/memory_estimate.h"

#include "vdblic/field/slabs.h"
#include "vdblic/methods/texture_params.h"

#include <algorithm>
#include <cmath>

namespace vdblic {
namespace {

constexpr double kTexture = 41; // bytes per voxel, including AUFLIC's particles, fewer than one per voxel
constexpr double kTextureBrick = sizeof(float) * 2 * BricksOf<2>::kSize;

} // namespace

double partInBricks(double leaves)
{
    constexpr double kSlabs = 3;
    const double layer = std::pow(leaves, 2.0 / 3);
    return std::min(1.0, kSlabs * (double(Slabs::fewestLeaves()) + layer / 2) / std::max(leaves, 1.0));
}

double denseBytes(const TextureParams& params, const FrameDomain& first, double more)
{
    const double velocity = double(first.velocity->local().size()), texture = double(first.texture->local().size());
    const double voxel = kTexture + more + (params.substeps > 1 ? 20 : 0);
    const bool isCubic = first.refinement.interpolation == Interpolation::kCubic;
    return kProcessBytes + (kVelocityBytes * velocity + voxel * texture) * Domain::kLeafVoxels +
           partInBricks(texture) * ((isCubic ? texture : velocity) * kVelocityBrickBytes + texture * kTextureBrick);
}

double denseBytes(double voxels)
{
    const double leaves = voxels / Domain::kLeafVoxels;
    return kProcessBytes + (kVelocityBytes + kTexture) * voxels +
           partInBricks(leaves) * leaves * (kVelocityBrickBytes + kTextureBrick);
}

double denseSeconds(double voxels, double frames)
{
    constexpr double kSeconds = 0.22e-6, kPreroll = 4;
    return voxels * (frames + kPreroll) * kSeconds;
}

} // namespace vdblic
