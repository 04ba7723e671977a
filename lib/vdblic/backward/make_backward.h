#pragma once

#include "vdblic/backward/backward_params.h"
#include "vdblic/lic/flow_texture.h"

#include <memory>

namespace vdblic {

/// The textures of a method that looks back along pathlines (looksBack()). @throws ParameterError
[[nodiscard]] std::unique_ptr<FlowTexture> makeBackwardTexture(const TextureParams& texture,
                                                               const BackwardParams& params, NoiseField noise);

} // namespace vdblic
