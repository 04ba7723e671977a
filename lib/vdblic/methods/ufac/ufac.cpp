#include "vdblic/methods/ufac/ufac.h"

#include "vdblic/methods/backward/backward_method.h"
#include "vdblic/methods/ufac/ufac_texture.h"

#include <memory>
#include <utility>

namespace vdblic {
namespace {

constexpr TextureMethod::Estimate kUfacEstimate{
    [](double velocity, double texture) { return backwardBytes(2, 0, velocity, texture); }, 1.8};

} // namespace

constinit const TextureMethod kUfac{
    .name = "ufac",
    .text = "moved noise, convolved along the streamlines of each frame",
    .preroll = lifeSpanOf,
    .leadIn = twoLifeSpansOf,
    .make = [](const MethodParams& params, MethodInput&& input) -> std::unique_ptr<FlowTexture> {
        return std::make_unique<UfacTexture>(params.texture, std::move(input.noise));
    },
    .describe = describeLifeSpan,
    .bytes = bytesByEstimate<kUfacEstimate>,
    .estimate = &kUfacEstimate,
};

} // namespace vdblic
