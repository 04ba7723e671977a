#include "vdblic/methods/lea/lea_texture.h"

#include "vdblic/field/domain_rows.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/vector.h"
#include "vdblic/lic/streamline_convolution.h"
#include "vdblic/methods/backward/cell_particles.h"

#include <cmath>
#include <cstddef>
#include <utility>

namespace vdblic {
namespace {

constexpr double kFilterHalf = 1; // steps

} // namespace

LeaTexture::LeaTexture(const TextureParams& texture, const BackwardParams& params, NoiseField noise)
    : BackwardTexture(texture, std::move(noise), {.particles = true, .texture = true}),
      mShare(params.stepShare(texture.lifeSpan, texture.substeps))
{
}

/// Noise, and the same scaled to the contrast of later textures.
BackwardTexture::Carried LeaTexture::first(const FlowStep& step) const
{
    const Domain& domain = *step.start.domain.texture;
    const CellParticles particles = CellParticles::centred(domain, noise());
    LeafValues<float> blended(domain, 0.0f, domain.own());
    const auto gain = float(std::sqrt(mShare / (2 - mShare)));
    forLeaves(domain.own(), [&](std::size_t leaf) {
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel) {
            const float value = particles.values[leaf][voxel.pos()] / CellParticles::kWhite;
            blended[leaf][voxel.pos()] = 0.5f + gain * (value - 0.5f);
        }
    });
    return {particles, blended};
}

LeafValues<float> LeaTexture::show(const FlowStep& step, const Carried& carried, StageClock& clock) const
{
    return StreamlineConvolution{step, kFilterHalf, params().pathline}(carried.texture, 1, clock);
}

BackwardTexture::Carried LeaTexture::pullBack(const FlowStep& step, const Carried& before, StageClock& clock) const
{
    const CellParticles particles = before.particles.moved(step, noise(), steps(), params().pathline, clock);
    const Domain &first = *step.start.domain.texture, &last = *step.end.domain.texture;
    LeafValues<float> blended(last, 0.0f, last.own());
    const auto share = float(mShare);
    forLeaves(last.own(), [&](std::size_t leaf) {
        const openvdb::Coord origin = last.origin(leaf);
        const int old = first.findLeaf(Int4{origin[0], origin[1], origin[2], 0});
        for (auto voxel = last.mask(leaf).beginOn(); voxel; ++voxel) {
            const float value = particles.values[leaf][voxel.pos()] / CellParticles::kWhite;
            const bool isNew = old < 0 || !first.isActive(old, voxel.pos());
            const float held = isNew ? value : before.texture[std::size_t(old)][voxel.pos()];
            blended[leaf][voxel.pos()] = (1 - share) * held + share * value;
        }
    });
    return {particles, blended};
}

} // namespace vdblic
