#include "vdblic/run/memory_estimate.h"

#include "vdblic/core/extent.h"
#include "vdblic/field/bricks.h"
#include "vdblic/field/field_domain.h"
#include "vdblic/field/slabs.h"
#include "vdblic/run/advect_params.h"
#include "vdblic/streaks/streak_shape.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

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

} // namespace

StreakCost streakCost(const StreakShape& shape, double voxels, double leaves, const openvdb::CoordBBox& box)
{
    constexpr double kDrawn = 90, kSeconds = 1.86e-7; // for the square of the texture voxels in a spacing, a streak
    double cells = voxels, inCell = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double spacing = std::min(double(shape.spacing[axis]), double(extentOf(box)[axis]));
        cells /= spacing;
        inCell *= spacing * shape.refinement.factors[axis];
    }
    const double drawn = cells * std::pow(inCell, 2.0 / 3);
    return {kProcess + (kVelocity * Domain::kLeafVoxels + kVelocityBrick) * leaves + kDrawn * drawn, kSeconds * drawn};
}

double backwardBytes(TextureMethod method, double velocity, double texture)
{
    // A texture, and floats that are carried from one frame to the next; only ibfv has bricks of them.
    const bool isIbfv = method == TextureMethod::kIbfv;
    const double carried = isIbfv ? 1 : method == TextureMethod::kUfac ? 2 : 3;
    const double brick = isIbfv ? sizeof(float) * 4 * BricksOf<4>::kSize : 0;
    const double leaves = texture / Domain::kLeafVoxels;
    return kProcess + kVelocity * velocity + sizeof(float) * (1 + 2 * carried) * texture +
           shareInBricks(leaves) * (velocity / Domain::kLeafVoxels * kVelocityBrick + leaves * brick);
}

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
        openvdb::CoordBBox box;
        (void)first.velocity->topology().evalActiveVoxelBoundingBox(box);
        const StreakShape shape = streakShape(params.streaks, params.flow.domain.refinement, *first.velocity, 0);
        return streakCost(shape, double(first.velocity->voxelCount()), velocity, box).bytes;
    }
    if (looksBack(params.texture.method))
        return backwardBytes(params.texture.method, velocity * Domain::kLeafVoxels, texture * Domain::kLeafVoxels);
    double voxel = kTexture;
    if (params.texture.method == TextureMethod::kUflic) voxel += kParticle * (params.texture.lifeSpan - 1);
    if (params.texture.method == TextureMethod::kAuflic2004) voxel += kParticle + 4 * params.texture.lifeSpan;
    if (params.texture.substeps > 1) voxel += 20;
    if (params.writesHits()) voxel += sizeof(std::int32_t);
    const bool isCubic = first.refinement.interpolation == Interpolation::kCubic;
    return kProcess + (kVelocity * velocity + voxel * texture) * Domain::kLeafVoxels +
           shareInBricks(texture) * ((isCubic ? texture : velocity) * kVelocityBrick + texture * kTextureBrick);
}

} // namespace vdblic
