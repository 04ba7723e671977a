#include "vdblic/run/memory_estimate.h"

#include "vdblic/field/field_domain.h"
#include "vdblic/run/advect_params.h"
#include "vdblic/streaks/streak_shape.h"

#include <cmath>
#include <cstddef>

namespace vdblic {

namespace {

// Bytes, and bytes a voxel; kTexture includes the less than one particle a voxel of AUFLIC with history.
constexpr double kProcess = 45e6, kVelocity = 46, kTexture = 33, kParticle = 41;

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
    return kProcess + (kVelocity + kTexture) * voxels;
}

double advectBytes(const AdvectParams& params, const FieldDomain& first)
{
    double texture = kTexture;
    if (params.texture.method == TextureMethod::kUflic) texture += kParticle * (params.texture.lifeSpan - 1);
    if (params.texture.method == TextureMethod::kAuflic2004) texture += kParticle + 4 * params.texture.lifeSpan;
    if (params.texture.substeps > 1) texture += 20;
    if (first.refinement.interpolation == Interpolation::kCubic) texture += 12;
    const auto voxels = [](const Domain& domain) { return double(domain.local().size()) * Domain::kLeafVoxels; };
    if (params.isSparse()) return kProcess + kVelocity * voxels(*first.velocity) + streakBytes(params, *first.velocity);
    return kProcess + kVelocity * voxels(*first.velocity) + texture * voxels(*first.texture);
}

} // namespace vdblic
