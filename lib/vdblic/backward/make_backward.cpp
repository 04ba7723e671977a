#include "vdblic/backward/make_backward.h"

#include "vdblic/backward/ibfv_texture.h"
#include "vdblic/backward/lea_texture.h"
#include "vdblic/backward/ufac_texture.h"

#include <utility>

namespace vdblic {

std::unique_ptr<FlowTexture> makeBackwardTexture(const TextureParams& texture, const BackwardParams& params,
                                                 NoiseField noise)
{
    texture.validate();
    params.validate();
    switch (texture.method) {
    case TextureMethod::kLea:
        return std::make_unique<LeaTexture>(texture, params, std::move(noise));
    case TextureMethod::kUfac:
        return std::make_unique<UfacTexture>(texture, std::move(noise));
    default:
        return std::make_unique<IbfvTexture>(texture, params, std::move(noise));
    }
}

} // namespace vdblic
