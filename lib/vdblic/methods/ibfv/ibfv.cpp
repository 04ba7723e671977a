#include "vdblic/methods/ibfv/ibfv.h"

#include "vdblic/field/bricks.h"
#include "vdblic/methods/backward/backward_method.h"
#include "vdblic/methods/ibfv/ibfv_texture.h"

#include <memory>
#include <utility>

namespace vdblic {
namespace {

constexpr TextureMethod::Estimate kIbfvEstimate{[](double velocity, double texture) {
                                                    return backwardBytes(1, sizeof(float) * 4 * BricksOf<4>::kSize,
                                                                         velocity, texture);
                                                },
                                                0.6};

} // namespace

constinit const TextureMethod kIbfv{
    .name = "ibfv",
    .text = "the texture before, pulled back and blended with noise",
    .blends = true,
    .preroll = settlingFrames,
    .leadIn = twoLifeSpansOf,
    .make = [](const MethodParams& params, MethodInput&& input) -> std::unique_ptr<FlowTexture> {
        return std::make_unique<IbfvTexture>(params.texture, params.backward, std::move(input.noise));
    },
    .describe = describeBlended,
    .bytes = bytesByEstimate<kIbfvEstimate>,
    .estimate = &kIbfvEstimate,
};

} // namespace vdblic
