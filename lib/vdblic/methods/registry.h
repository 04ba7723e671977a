#pragma once

#include "vdblic/methods/flow_texture.h"
#include "vdblic/methods/method_params.h"
#include "vdblic/methods/texture_method.h"

#include <memory>
#include <span>
#include <string_view>

namespace vdblic {

/// All methods, in the order in which help and reports list them.
[[nodiscard]] std::span<const TextureMethod* const> textureMethods();

/// The method of a name. @throws ParameterError, which lists all names
[[nodiscard]] const TextureMethod& textureMethod(std::string_view name);

/// The textures of `params.texture.method`. @throws ParameterError
[[nodiscard]] std::unique_ptr<FlowTexture> makeFlowTexture(const MethodParams& params, MethodInput input);

} // namespace vdblic
