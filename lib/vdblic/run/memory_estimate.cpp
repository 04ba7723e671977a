#include "vdblic/run/memory_estimate.h"

#include "vdblic/field/flow_frame.h"
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

double advectBytes(const AdvectParams& params, const FlowFrame& first)
{
    double texture = kTexture;
    if (params.scatter.method == ScatterMethod::kUflic) texture += kParticle * (params.scatter.lifeSpan - 1);
    if (params.scatter.substeps > 1) texture += 20;
    if (first.refinement.interpolation == Interpolation::kCubic) texture += 12;
    const auto voxels = [](const Domain& domain) { return double(domain.local().size()) * Domain::kLeafVoxels; };
    return kProcess + kVelocity * voxels(*first.velocityDomain()) + texture * voxels(*first.domain);
}

} // namespace vdblic
