#include "vdblic/backward/make_backward.h"

#include "vdblic/backward/ibfv_texture.h"

#include <utility>

namespace vdblic {

std::unique_ptr<FlowTexture> makeBackwardTexture(const TextureParams& texture, const BackwardParams& params,
                                                 NoiseField noise)
{
    texture.validate();
    params.validate();
    return std::make_unique<IbfvTexture>(texture, params, std::move(noise));
}

} // namespace vdblic
