#pragma once

#include "vdblic/methods/texture_method.h"

namespace vdblic {

/// Image based flow visualization: the previous texture, pulled back and blended with noise (IbfvTexture). Van Wijk,
/// "Image based flow visualization", SIGGRAPH 2002.
extern const TextureMethod kIbfv;

} // namespace vdblic
