#pragma once

#include "vdblic/methods/texture_method.h"

namespace vdblic {

/// Lagrangian-Eulerian advection: moved noise, blended from frame to frame (LeaTexture). Jobard, Erlebacher & Hussaini,
/// "Lagrangian-Eulerian advection of noise and dye textures for unsteady flow visualization", TVCG 8(3), 2002.
extern const TextureMethod kLea;

} // namespace vdblic
