#include "vdblic/lic/flow_texture.h"

#include "vdblic/lic/scattered_texture.h"
#include "vdblic/lic/steady_texture.h"

#include <utility>

namespace vdblic {

std::unique_ptr<FlowTexture> makeFlowTexture(const TextureParams& params, NoiseField noise)
{
    params.validate();
    if (isSteady(params.method)) return std::make_unique<SteadyTexture>(params, std::move(noise));
    return std::make_unique<ScatteredTexture>(params, std::move(noise));
}

} // namespace vdblic
