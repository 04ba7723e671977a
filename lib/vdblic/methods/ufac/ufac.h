#pragma once

#include "vdblic/methods/texture_method.h"

namespace vdblic {

/// Unsteady flow advection-convolution: moved noise, convolved along streamlines (UfacTexture). Weiskopf, Erlebacher &
/// Ertl, "A texture-based framework for spacetime-coherent visualization of time-dependent vector fields",
/// Visualization 2003.
extern const TextureMethod kUfac;

} // namespace vdblic
