#include "vdblic/methods/auflic/auflic.h"

#include "vdblic/lic/finish.h"
#include "vdblic/methods/auflic/scattered_texture.h"
#include "vdblic/methods/memory_estimate.h"
#include "vdblic/methods/method_params.h"

#include <memory>
#include <utility>

namespace vdblic {
namespace {

constexpr double kParticleBytes = 30;

std::unique_ptr<FlowTexture> makeScattered(const MethodParams& params, MethodInput&& input)
{
    return std::make_unique<ScatteredTexture>(params.texture, std::move(input.noise));
}

void describeScattered(const MethodParams& params, openvdb::MetaMap& metadata)
{
    describeLifeSpan(params, metadata);
    metadata.insertMeta("sharpen", openvdb::FloatMetadata(params.texture.feedback.sharpen));
    metadata.insertMeta("noise_share", openvdb::FloatMetadata(params.texture.feedback.noiseShare));
}

void describeAccelerated(const MethodParams& params, openvdb::MetaMap& metadata)
{
    describeScattered(params, metadata);
    metadata.insertMeta("release_window", openvdb::FloatMetadata(params.texture.releaseWindow));
}

/// @param particles bytes per voxel beyond those of auflic
double scatteredBytes(double particles, const MethodParams& params, const FrameDomain& first, bool withHits)
{
    return denseBytes(params.texture, first, particles + (withHits ? sizeof(std::int32_t) : 0));
}

} // namespace

constinit const TextureMethod kAuflic{
    .name = "auflic",
    .text = "accelerated UFLIC",
    .scatter = &kScatterFading,
    .finish = FinishParams{}.taps,
    .preroll = lifeSpanOf,
    .leadIn = twoLifeSpansOf,
    .make = makeScattered,
    .describe = describeAccelerated,
    .bytes = [](const MethodParams& params, const FrameDomain& first, const Refinement& /*given*/,
                bool withHits) { return scatteredBytes(0, params, first, withHits); },
};

constinit const TextureMethod kAuflic2004{
    .name = "auflic-2004",
    .text = "the same as published",
    .scatter = &kScatterWindow,
    .preroll = lifeSpanOf,
    .leadIn = twoLifeSpansOf,
    .make = makeScattered,
    .describe = describeAccelerated,
    .bytes =
        [](const MethodParams& params, const FrameDomain& first, const Refinement& /*given*/, bool withHits) {
            return scatteredBytes(kParticleBytes + 4 * params.texture.lifeSpan, params, first, withHits);
        },
};

constinit const TextureMethod kUflic{
    .name = "uflic",
    .text = "a seed for every voxel and frame",
    .scatter = &kScatterSingle,
    .finish = FinishParams{}.taps,
    .preroll = lifeSpanOf,
    .leadIn = twoLifeSpansOf,
    .make = makeScattered,
    .describe = describeScattered,
    .bytes =
        [](const MethodParams& params, const FrameDomain& first, const Refinement& /*given*/, bool withHits) {
            return scatteredBytes(kParticleBytes * (params.texture.lifeSpan - 1), params, first, withHits);
        },
};

} // namespace vdblic
