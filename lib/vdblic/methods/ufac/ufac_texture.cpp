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

using TextureVelocities = Velocities<Space::kTexture, Per::kStep>;

/// The share of the kernel over which streamline and pathline stay together.
/// @param change of the velocity in a step [voxels]  @param half of the kernel [steps]
VDBLIC_INLINE Float8 partOf(const Vector8& change, float half)
{
    constexpr float kApart = 1; // voxels
    const Float8 changes = squareRoots(squaredLength(change));
    const Float8 steps = squareRoots(2 * kApart / (changes > 1e-12f ? changes : broadcast8(1e-12f)));
    return steps < half ? steps / half : broadcast8(1);
}

/// @param next   domain of the step's second frame  @param origin of a leaf of the first one's
/// @param before, after velocities of the two frames
VDBLIC_KERNEL void fillParts(const Domain& next, const Refinement& refinement, const openvdb::Coord& origin,
                             const TextureVelocities& before, const TextureVelocities& after, float half, float* parts)
{
    const LeafVelocities now(before, refinement, origin), then(after, refinement, origin);
    const int leafThen = next.findLeaf(Int4{origin[0], origin[1], origin[2], 0});
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const Int8 stays = leafThen < 0 ? Int8{} : activeRow(next.mask(std::size_t(leafThen)), row);
        const Float8 part = partOf(then.row(row) - now.row(row), half);
        storeRow(stays ? part : broadcast8(1), parts, row);
    }
}

} // namespace

UfacTexture::UfacTexture(const TextureParams& texture, NoiseField noise)
    : BackwardTexture(texture, std::move(noise), {.particles = true, .texture = false})
{
}

Lengths<Space::kTexture> UfacTexture::farthestPath(const Speeds<Space::kTexture, Per::kFrame>& fastest,
                                                   double seconds) const
{
    Lengths<Space::kTexture> farthest = BackwardTexture::farthestPath(fastest, seconds);
    for (std::size_t axis = 0; axis < 3; ++axis)
        farthest.along[axis] = std::max(farthest[axis], longestPath(0.5f * float(params().lifeSpan) * fastest[axis]));
    return farthest;
}

BackwardTexture::Carried UfacTexture::first(const FlowStep& step) const
{
    return {CellParticles::centred(*step.start.domain.texture, noise()), {}};
}

LeafValues<float> UfacTexture::show(const FlowStep& step, const Carried& carried, StageClock& clock) const
{
    const double half = params().kernelHalf();
    const Domain &domain = *step.start.domain.texture, &next = *step.end.domain.texture;
    const Refinement& refinement = step.start.domain.refinement;
    const TextureVelocities before = refinement.toTexture(step.startVelocities()),
                            after = refinement.toTexture(step.endVelocities());
    const StreamlineConvolution convolution{step, half, params().pathline, [&](std::size_t leaf, float* parts) {
                                                fillParts(next, refinement, domain.origin(leaf), before, after,
                                                          float(half), parts);
                                            }};
    return convolution(carried.particles.values, CellParticles::kWhite, clock);
}

BackwardTexture::Carried UfacTexture::pullBack(const FlowStep& step, const Carried& before, StageClock& clock) const
{
    return {before.particles.moved(step, noise(), steps(), params().pathline, clock), {}};
}

} // namespace vdblic
