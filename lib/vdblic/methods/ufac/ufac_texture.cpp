#include "vdblic/methods/ufac/ufac_texture.h"

#include "vdblic/field/domain_rows.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"
#include "vdblic/lic/leaf_velocities.h"
#include "vdblic/lic/path_reach.h"
#include "vdblic/lic/streamline_convolution.h"
#include "vdblic/methods/backward/cell_particles.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace vdblic {
namespace {

enum : std::size_t { kParticleValues, kParticleOffsets }; // index in Carried

/// The part of the kernel to take, so that its streamline and the pathline stay together.
/// @param change of the velocity in a step [voxels]  @param half of the kernel [steps]
VDBLIC_INLINE Float8 partOf(const Vector8& change, float half)
{
    constexpr float kApart = 1; // voxels
    const Float8 changes = squareRoots(squaredLength(change));
    const Float8 steps = squareRoots(2 * kApart / (changes > 1e-12f ? changes : broadcast8(1e-12f)));
    return steps < half ? steps / half : broadcast8(1);
}

VDBLIC_KERNEL void fillParts(const FlowStep& step, float half, std::size_t leaf, float* parts)
{
    const Domain &domain = *step.start.domain, &next = *step.end.domain;
    const openvdb::Coord origin = domain.origin(leaf);
    const Refinement& refinement = step.start.refinement;
    const openvdb::Mat3d toTexture = refinement.toTexture();
    const LeafVelocities now({step.start.velocities->tree(), toTexture * step.startToStep}, refinement, origin),
        then({step.end.velocities->tree(), toTexture * step.endToStep}, refinement, origin);
    const int leafThen = next.findLeaf(Int4{origin[0], origin[1], origin[2], 0});
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const Int8 stays = leafThen < 0 ? Int8{} : activeRow(next.mask(std::size_t(leafThen)), row);
        const Float8 part = partOf(then.row(row) - now.row(row), half);
        storeRow(stays ? part : broadcast8(1), parts, row);
    }
}

} // namespace

UfacTexture::UfacTexture(const TextureParams& texture, NoiseField noise)
    : BackwardTexture(texture, std::move(noise), {"noise", "offset"})
{
}

std::array<float, 3> UfacTexture::farthestPath(const std::array<float, 3>& displacement, double interval) const
{
    std::array<float, 3> farthest = BackwardTexture::farthestPath(displacement, interval);
    for (std::size_t axis = 0; axis < 3; ++axis)
        farthest[axis] = std::max(farthest[axis], longestPath(0.5f * float(params().lifeSpan) * displacement[axis]));
    return farthest;
}

BackwardTexture::Carried UfacTexture::first(const FlowStep& step) const
{
    const CellParticles particles = CellParticles::centred(*step.start.domain, noise());
    return {particles.values, particles.offsets};
}

LeafValues<float> UfacTexture::show(const FlowStep& step, const Carried& carried, StageClock& clock) const
{
    const double half = params().kernelHalf();
    const StreamlineConvolution convolution{
        step.start, step.startToStep, half, params().pathline,
        [&](std::size_t leaf, float* parts) { fillParts(step, float(half), leaf, parts); }};
    return convolution(carried[kParticleValues], CellParticles::kWhite, clock);
}

BackwardTexture::Carried UfacTexture::pullBack(const FlowStep& step, const Carried& before, StageClock& clock) const
{
    const CellParticles particles = CellParticles{before[kParticleValues], before[kParticleOffsets]}.moved(
        step, noise(), steps(), params().pathline, clock);
    return {particles.values, particles.offsets};
}

} // namespace vdblic
