#include "vdblic/methods/lea/lea.h"

#include "vdblic/methods/backward/backward_method.h"
#include "vdblic/methods/lea/lea_texture.h"

#include <memory>
#include <utility>

namespace vdblic {
namespace {

constexpr TextureMethod::Estimate kLeaEstimate{
    [](double velocity, double texture) { return backwardBytes(3, 0, velocity, texture); }, 1.3};

} // namespace

constinit const TextureMethod kLea{
    .name = "lea",
    .text = "moved noise, blended from frame to frame",
    .blends = true,
    .preroll = settlingFrames,
    .leadIn = twoLifeSpansOf,
    .make = [](const MethodParams& params, MethodInput&& input) -> std::unique_ptr<FlowTexture> {
        return std::make_unique<LeaTexture>(params.texture, params.backward, std::move(input.noise));
    },
    .describe = describeBlended,
    .bytes = bytesByEstimate<kLeaEstimate>,
    .estimate = &kLeaEstimate,
};

} // namespace vdblic
