#pragma once

#include "vdblic/render/lanes.h"

#include <cstring>

namespace vdblic {

/// A ray to trace. Places are in index space, counted as VisibleLeaves does; distances along it are in steps.
struct alignas(32) RayTask {
    Float4 entry, direction; ///< the direction has length 1; fourth lanes 0
    Float4 inverse;          ///< of the direction's components, huge for those near 0
    Float8 shading;          ///< what shading needs to know, by RayNumber
    float shift;             ///< length of the first step
    float span;              ///< from entry to exit
    int samples;             ///< that represent the span
    int pixel;
};

/// The numbers of RayTask::shading.
enum RayNumber {
    kViewX, ///< direction in world space, of length 1
    kViewY,
    kViewZ,
    kFaceLit,    ///< the share of its colour that the face shows through which the ray comes in; negative: no face
    kFaceWhite,  ///< the light that face adds to it
    kEntryDepth, ///< along the view axis [world]
    kDepthPerStep,
};

/// Samples that are seen and wait to be shaded, of any rays, side by side.
///
/// They wait until there are many, so that the processor can mostly foresee that there are not enough yet.
struct ShadeQueue {
    static constexpr int kMany = 128, kCapacity = kMany + 4 * kLanes;

    float fraction[3][kCapacity]; ///< place in the cell
    unsigned record[kCapacity];   ///< number of the record at the cell's lowest corner
    int task[kCapacity];          ///< number of the ray
    float place[kCapacity];       ///< along the ray [steps]
    float weight[kCapacity];      ///< in the pixel
    float stretched[kCapacity];   ///< the texture
    int entry[kCapacity];         ///< of the transfer function
    int begin = 0, end = 0;

    /// Write some lanes to one of the arrays, from a place on. @param order the lanes, of kPacking
    template<typename T, typename Vector>
    VDBLIC_INLINE static void put(T* place, Vector values, Int8 order)
    {
        const Vector packed = __builtin_shuffle(values, order);
        std::memcpy(place, &packed, sizeof packed);
    }

    /// Move what is left to the front.
    VDBLIC_INLINE void compact()
    {
        const auto shift = [&](auto* array) { std::memmove(array, array + begin, kLanes * sizeof *array); };
        for (float* array : {fraction[0], fraction[1], fraction[2], place, weight, stretched})
            shift(array);
        shift(record);
        for (int* array : {task, entry})
            shift(array);
        end -= begin;
        begin = 0;
    }
};

/// What the samples of a ray add up to.
struct alignas(16) RaySum {
    Float4 color{};   ///< red, green, blue, premultiplied
    Float4 normal{};  ///< times weight, as what follows
    Float4 numbers{}; ///< depth, magnitude, texture
    float alpha = 0;
    float halo = 0;      ///< the part of alpha that is halo
    float haloPlace = 0; ///< along the ray [steps], times that
    float waiting = 0;   ///< the part of alpha that was too little to be shaded
    int samples = 0;
};

} // namespace vdblic
