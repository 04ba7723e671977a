#include "vdblic/run/memory_estimate.h"

#include "vdblic/field/field_domain.h"
#include "vdblic/run/advect_params.h"

namespace vdblic {

namespace {

// Bytes, and bytes a voxel; kTexture includes the less than one particle a voxel of AUFLIC with history.
constexpr double kProcess = 45e6, kVelocity = 46, kTexture = 33, kParticle = 41;

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
    return kProcess + kVelocity * voxels(*first.velocity) + texture * voxels(*first.texture);
}

} // namespace vdblic
