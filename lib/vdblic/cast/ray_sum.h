#pragma once

#include "vdblic/field/vector.h"

namespace vdblic {

/// What the samples of a ray add up to. Weights are shares of the pixel's alpha.
struct alignas(16) RaySum {
    Float4 color{};   ///< red, green, blue, premultiplied; and the weight of the background that is seen in samples
    Float4 normal{};  ///< times weight
    Float4 numbers{}; ///< depth, driver, texture, each times weight
    float alpha = 0;
    float halo = 0;         ///< weight of halos
    float haloDistance = 0; ///< along the ray [steps], times that weight
    float waiting = 0;      ///< weight of samples that were too faint to be shaded
    int samples = 0;
};

} // namespace vdblic
