#include "vdblic/methods/lic/lic.h"

#include "vdblic/methods/lic/steady_texture.h"
#include "vdblic/methods/memory_estimate.h"
#include "vdblic/methods/method_params.h"

#include <memory>
#include <utility>

namespace vdblic {
namespace {

int noFrames(const MethodParams& /*params*/)
{
    return 0;
}

} // namespace

constinit const TextureMethod kLic{
    .name = "lic",
    .text = "each frame on its own",
    .isSteady = true,
    .preroll = noFrames,
    .leadIn = noFrames,
    .make = [](const MethodParams& params, MethodInput&& input) -> std::unique_ptr<FlowTexture> {
        return std::make_unique<SteadyTexture>(params.texture, std::move(input.noise));
    },
    .describe = describeLifeSpan,
    .bytes = [](const MethodParams& params, const FrameDomain& first, const Refinement& /*given*/,
                bool /*withHits*/) { return denseBytes(params.texture, first, 0); },
};

} // namespace vdblic
