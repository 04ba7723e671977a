#pragma once

#include "vdblic/field/vector.h"

namespace vdblic {

/// A ray to trace. Positions are in index space relative to VisibleSpace::origin(); distances along the ray are in
/// steps from the entry. The size is a power of two, so that indexing needs no multiplication.
struct alignas(128) RayTask {
    Float4 entry, direction; ///< the direction has length 1; fourth lanes 0
    Float4 inverse;          ///< reciprocals of the direction's components, huge near 0
    Float8 shading;          ///< constants for shading, indexed by RayNumber
    float shift;             ///< length of the first step
    float span;              ///< from entry to exit
    int samples;             ///< that represent the span
    int pixel;
};

/// Lanes of RayTask::shading.
enum RayNumber {
    kViewX, ///< direction in world space, of length 1
    kViewY,
    kViewZ,
    kFaceLit,    ///< of the face where the ray enters: share of a sample's colour that is seen; negative: no face
    kFaceWhite,  ///< of that face: light added to the colour
    kEntryDepth, ///< along the view axis [world]
    kDepthPerStep,
};

/// Sums over the samples of a ray. Weights are shares of the pixel's alpha.
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
