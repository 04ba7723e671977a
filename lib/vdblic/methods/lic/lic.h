#pragma once

#include "vdblic/methods/texture_method.h"

namespace vdblic {

/// Line integral convolution of each frame on its own (SteadyTexture). Cabral & Leedom, "Imaging vector fields using
/// line integral convolution", SIGGRAPH 1993.
extern const TextureMethod kLic;

} // namespace vdblic
