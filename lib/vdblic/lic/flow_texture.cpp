#include "vdblic/lic/flow_texture.h"

#include "vdblic/lic/scattered_texture.h"
#include "vdblic/lic/steady_texture.h"

#include <utility>

namespace vdblic {

std::optional<std::string> FlowTexture::begin(const Domain& /*velocity*/, double /*displacement*/)
{
    return std::nullopt;
}

std::unique_ptr<FlowTexture> makeFlowTexture(const TextureParams& params, NoiseField noise)
{
    params.validate();
    if (isSteady(params.method)) return std::make_unique<SteadyTexture>(params, std::move(noise));
    return std::make_unique<ScatteredTexture>(params, std::move(noise));
}

} // namespace vdblic
