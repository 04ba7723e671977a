#pragma once

#include "vdblic/field/velocity_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace vdblic {

/// How pathlines are integrated and sampled.
struct PathlineParams {
    float tolerance = 0.05f;    ///< largest estimated error of one integration step [voxels]
    float sampleSpacing = 0.5f; ///< distance between samples along the path [voxels]

    void validate() const; ///< @throws ParameterError
};

/// One integration step as a cubic Hermite curve.
struct Segment {
    Float4 start, end;           ///< index space, voxel centres at integers
    Float4 startSlope, endSlope; ///< velocity there, voxels per time step
    float time, duration;        ///< of the whole time step, 0 to 1
};

/// Samples on a segment, eight at a time.
struct SampleBlock {
    Int8 x, y, z; ///< the voxels they lie in
    Float8 time;  ///< as fractions of the time step
    int count;    ///< how many of the eight are samples
};

/// How many particles are advanced side by side: enough loads in flight to hide the memory's latency.
inline constexpr int kLanes = 8;

/// Particles to advance together, and the paths they took.
struct PathBatch {
    int count = 0;
    std::array<Float4, kLanes> position; ///< index space, fourth lane 0; updated
    std::array<Float4, kLanes> slope;    ///< velocity there at the step's start; updated to that at its end
    std::array<std::vector<Segment>, kLanes> path;
    std::size_t steps = 0; ///< integration steps tried since the batch was made
};

namespace pathline {

// A step crosses no more than one leaf, and is never cut below 1/4096 of a time step.
inline constexpr float kMaxStride = 8;
inline constexpr float kMinDuration = 1.0f / 4096;

VDBLIC_INLINE float length(Float4 v)
{
    return __builtin_sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/// The longest duration whose stride stays within kMaxStride.
VDBLIC_INLINE float strideLimit(Float4 slope)
{
    return kMaxStride / std::max(length(slope), kMaxStride);
}

} // namespace pathline

/// Advance every particle of a batch by one time step.
///
/// Classical RK4 whose end slope serves as the next step's first (FSAL) and gives the embedded third-order error
/// estimate |h/6 (k4 − k5)|; the duration is halved and grown to keep it under the tolerance. Fourth order in
/// space, second in time, where the velocity is linear between frames (Liu & Moorhead 2004, Table 1). A stage that
/// falls where the field has no value goes straight on. A path stops after the segment that left the domain.
/// Each lane is a pure function of its own position and slope. Hairer, Nørsett & Wanner, Solving ODEs I, II.4.
VDBLIC_INLINE void advancePaths(const VelocityField& field, const PathlineParams& params, PathBatch& batch)
{
    std::array<int, kLanes> lanes;
    std::array<float, kLanes> time, duration;
    std::array<Float4, kLanes> k2, k3, k4, end;
    for (int m = 0; m < batch.count; ++m) {
        lanes[std::size_t(m)] = m;
        time[std::size_t(m)] = 0;
        duration[std::size_t(m)] = pathline::strideLimit(batch.slope[std::size_t(m)]);
        batch.path[std::size_t(m)].clear();
    }
    std::size_t active = std::size_t(batch.count);
    while (active > 0) {
        batch.steps += active;
        for (std::size_t i = 0; i < active; ++i) {
            const auto m = std::size_t(lanes[i]);
            const float half = 0.5f * duration[m];
            k2[m] = field.sample(batch.position[m] + batch.slope[m] * half, time[m] + half, batch.slope[m]);
        }
        for (std::size_t i = 0; i < active; ++i) {
            const auto m = std::size_t(lanes[i]);
            const float half = 0.5f * duration[m];
            k3[m] = field.sample(batch.position[m] + k2[m] * half, time[m] + half, k2[m]);
        }
        for (std::size_t i = 0; i < active; ++i) {
            const auto m = std::size_t(lanes[i]);
            k4[m] = field.sample(batch.position[m] + k3[m] * duration[m], time[m] + duration[m], k3[m]);
            end[m] = batch.position[m] + (batch.slope[m] + (k2[m] + k3[m]) * 2.0f + k4[m]) * (duration[m] * (1.0f / 6));
        }
        std::size_t kept = 0;
        for (std::size_t i = 0; i < active; ++i) {
            const auto m = std::size_t(lanes[i]);
            const Float4 k5 = field.sample(end[m], time[m] + duration[m], k4[m]);
            const float error = pathline::length(k4[m] - k5) * duration[m] * (1.0f / 6);
            // The estimate shrinks with the fourth power of the duration; aim a little below the tolerance.
            const float ratio = params.tolerance / std::max(error, 1e-6f * params.tolerance);
            const float factor = std::clamp(0.9f * __builtin_sqrtf(__builtin_sqrtf(ratio)), 0.2f, 4.0f);
            if (error > params.tolerance && duration[m] > pathline::kMinDuration) {
                duration[m] = std::max(duration[m] * factor, pathline::kMinDuration);
                lanes[kept++] = int(m);
                continue;
            }
            batch.path[m].push_back({batch.position[m], end[m], batch.slope[m], k5, time[m], duration[m]});
            batch.position[m] = end[m];
            batch.slope[m] = k5;
            const float rest = 1 - time[m];
            if (duration[m] >= rest || !field.domain().contains(end[m])) continue;
            time[m] += duration[m];
            const float wanted = std::min(duration[m] * factor, pathline::strideLimit(k5));
            duration[m] = std::min(std::max(wanted, pathline::kMinDuration), 1 - time[m]);
            lanes[kept++] = int(m);
        }
        active = kept;
    }
}

/// Visit the samples of a segment: the middles of even pieces of its length, so that their mean is the segment's.
///
/// @param visit called with blocks of up to eight samples in order; returns whether to go on
/// @return whether every block was visited
/// Cubic Hermite dense output: Hairer, Nørsett & Wanner, Solving ODEs I, II.6. Even arc length takes the speed to
/// change linearly over the segment.
template<typename Visit>
VDBLIC_INLINE bool visitSamples(const Segment& segment, float spacing, const Visit& visit)
{
    // Per segment instead of per time step; the least speed keeps a path at rest from dividing by zero.
    constexpr float kLeastSpeed = 1e-3f;
    const Float4 m0 = segment.startSlope * segment.duration, m1 = segment.endSlope * segment.duration;
    const Float4 chord = segment.end - segment.start;
    const Float4 c2 = chord * 3.0f - m0 * 2.0f - m1, c3 = m0 + m1 - chord * 2.0f;
    const float speed0 = pathline::length(m0) + kLeastSpeed, speed1 = pathline::length(m1) + kLeastSpeed;
    const float arc = 0.5f * (speed0 + speed1);
    const float longest = std::max(arc, pathline::length(chord));
    constexpr float kMostSamples = 1e6f; // only a velocity that overflowed asks for more
    const int count = std::max(1, int(std::ceil(std::min(kMostSamples, longest / spacing))));
    const float arcStep = arc / float(count);
    const Float8 first = {0, 1, 2, 3, 4, 5, 6, 7};
    for (int done = 0; done < count; done += 8) {
        const Float8 s = (first + (float(done) + 0.5f)) * arcStep;
        const Float8 square = s * (2 * (speed1 - speed0)) + speed0 * speed0;
        Float8 root;
        for (int i = 0; i < 8; ++i)
            root[i] = __builtin_sqrtf(square[i] > 0 ? square[i] : 0);
        const Float8 u = s * 2.0f / (root + speed0);
        const auto voxels = [&](int axis) {
            return floorToInt(((u * c3[axis] + c2[axis]) * u + m0[axis]) * u + (segment.start[axis] + 0.5f));
        };
        const SampleBlock block{voxels(0), voxels(1), voxels(2), u * segment.duration + segment.time,
                                std::min(8, count - done)};
        if (!visit(block)) return false;
    }
    return true;
}

} // namespace vdblic
