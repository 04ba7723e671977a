#include "vdblic/run/memory_estimate.h"

#include "vdblic/field/bricks.h"
#include "vdblic/field/field_domain.h"
#include "vdblic/field/slabs.h"
#include "vdblic/run/advect_params.h"
#include "vdblic/streaks/streak_shape.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vdblic {

namespace {

// Bytes, and bytes a voxel of leaves; kTexture includes the less than one particle a voxel of AUFLIC with history.
constexpr double kProcess = 44e6, kVelocity = 29, kTexture = 41, kParticle = 30;
constexpr double kVelocityBrick = sizeof(float) * 8 * BricksOf<8>::kSize,
                 kTextureBrick = sizeof(float) * 2 * BricksOf<2>::kSize;

/// The share of a domain whose bricks are in memory at a time: three slabs of whole layers, as of a cube.
double shareInBricks(double leaves)
{
    constexpr double kSlabs = 3;
    const double layer = std::pow(leaves, 2.0 / 3);
    return std::min(1.0, kSlabs * (double(Slabs::fewestLeaves()) + layer / 2) / std::max(leaves, 1.0));
}

/// Of streaks with tails of some spacings, and of what is drawn of them.
double streakBytes(const AdvectParams& params, const Domain& velocity)
{
    constexpr double kVoxel = 90; // for the square of the texture voxels in a spacing
    const StreakShape shape = streakShape(params.streaks, params.flow.domain.refinement, velocity, 0);
    double cells = double(velocity.voxelCount()), voxels = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        cells /= double(shape.spacing[axis]);
        voxels *= double(shape.spacing[axis]) * shape.refinement.factors[axis];
    }
    return kVoxel * cells * std::pow(voxels, 2.0 / 3);
}

} // namespace

double advectBytes(double voxels)
{
    const double leaves = voxels / Domain::kLeafVoxels;
    return kProcess + (kVelocity + kTexture) * voxels +
           shareInBricks(leaves) * leaves * (kVelocityBrick + kTextureBrick);
}

double advectBytes(const AdvectParams& params, const FieldDomain& first)
{
    const double velocity = double(first.velocity->local().size()), texture = double(first.texture->local().size());
    if (params.isSparse()) {
        return kProcess + (kVelocity * Domain::kLeafVoxels + kVelocityBrick) * velocity +
               streakBytes(params, *first.velocity);
    }
    double voxel = kTexture;
    if (params.texture.method == TextureMethod::kUflic) voxel += kParticle * (params.texture.lifeSpan - 1);
    if (params.texture.method == TextureMethod::kAuflic2004) voxel += kParticle + 4 * params.texture.lifeSpan;
    if (params.texture.substeps > 1) voxel += 20;
    const bool isCubic = first.refinement.interpolation == Interpolation::kCubic;
    return kProcess + (kVelocity * velocity + voxel * texture) * Domain::kLeafVoxels +
           shareInBricks(texture) * ((isCubic ? texture : velocity) * kVelocityBrick + texture * kTextureBrick);
}

} // namespace vdblic
