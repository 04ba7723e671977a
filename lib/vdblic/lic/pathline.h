#pragma once

#include "vdblic/field/domain_rows.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/vector.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/pathline_params.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <vector>

namespace vdblic {

/// One integration step of up to eight particles, each a cubic Hermite curve.
struct Segment {
    Vector8 start, end;           ///< index space, voxel centres at integers
    Vector8 startSlope, endSlope; ///< velocity there, voxels per time step
    Float8 time, duration;        ///< of the whole time step, 0 to 1
    unsigned lanes;               ///< bits of the lanes that took this step
};

/// Particles to advance together, and their paths.
struct PathBatch {
    Vector8 position{};            ///< index space; updated
    Vector8 slope{};               ///< velocity there at the step's start; updated to the velocity at its end
    std::vector<Segment> segments; ///< in order of time, for every lane
    std::size_t steps = 0;         ///< integration steps tried since the batch was created
    unsigned lanes = 0;            ///< bits of the lanes that hold a particle
    unsigned arrived = 0;          ///< bits of the lanes whose path lasts to the end of the time step
};

namespace pathline {

// A step crosses no more than one leaf, and is never cut below 1/4096 of a time step.
inline constexpr float kMaxStride = 8;
inline constexpr float kMinDuration = 1.0f / 4096;

/// Offsets across a path, added to its samples in turn: the corners of a tetrahedron, without their parts along the
/// path. A path near the border of two voxel rows thus leaves values in both, in proportion to its distance; without
/// offsets it would change rows abruptly.
struct Offsets {
    static constexpr int kCount = 4;
    Vector8 of[kCount];

    /// @param chord from the path's start to its end, of the given length
    VDBLIC_INLINE Offsets(const Vector8& chord, Float8 length)
    {
        constexpr float kOffset = 0.2f; // voxels
        constexpr float corners[kCount][3] = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
        const Vector8 direction = chord * (1 / (length > 1e-6f ? length : broadcast8(1)));
        for (int i = 0; i < kCount; ++i) {
            const Float8 along =
                direction.x * corners[i][0] + direction.y * corners[i][1] + direction.z * corners[i][2];
            of[i] = {kOffset * (corners[i][0] - direction.x * along), kOffset * (corners[i][1] - direction.y * along),
                     kOffset * (corners[i][2] - direction.z * along)};
        }
    }
};

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

/// Advance every particle of a batch by one time step, or by a part of it.
///
/// Classical RK4. The end slope k5 is the next step's first (FSAL) and gives the embedded third-order error estimate
/// |h/6 (k4 − k5)|; the duration h adapts to keep it under the tolerance. Fourth order in space; second in time,
/// because velocity is linear between frames (Liu & Moorhead 2004, Table 1). A stage without a velocity uses the
/// previous stage's. A path stops after the segment that left the domain. Each lane is a pure function of its own
/// position and slope. Hairer, Nørsett & Wanner, Solving ODEs I, II.4.
///
/// @param window of the leaf that the particles are in, or an empty one; affects speed only
/// @param from, to part of the step, 0 to 1; `arrived` refers to its end
/// Thread-safe for distinct batches.
VDBLIC_INLINE void advancePaths(const VelocityField& field, const Bricks::Window& window, const PathlineParams& params,
                                PathBatch& batch, float from = 0, float to = 1)
{
    const float tolerance2 = params.tolerance * params.tolerance;
    batch.segments.clear();
    batch.arrived = 0;
    Float8 time = broadcast8(from), duration = broadcast8(to - from);
    if (anyOf(squaredLength(batch.slope) > pathline::kMaxStride * pathline::kMaxStride)) {
        for (int i = 0; i < kLanes; ++i)
            duration[i] = std::min(pathline::strideLimit(batch.slope.lane(i)), to - from);
    }
    for (unsigned active = batch.lanes; active != 0;) {
        batch.steps += std::size_t(std::popcount(active));
        const Vector8 start = batch.position, k1 = batch.slope;
        const Float8 half = duration * 0.5f;
        const Vector8 k2 = field.sample(window, start + k1 * half, time + half, k1, active);
        const Vector8 k3 = field.sample(window, start + k2 * half, time + half, k2, active);
        const Vector8 k4 = field.sample(window, start + k3 * duration, time + duration, k3, active);
        const Vector8 end = start + (k1 + (k2 + k3) * 2.0f + k4) * (duration * (1.0f / 6));
        const Vector8 k5 = field.sample(window, end, time + duration, k4, active);

        const Float8 error2 = squaredLength(k4 - k5) * (duration * duration * (1.0f / 36));
        const Int8 rejected = (error2 > tolerance2) & (duration > pathline::kMinDuration);
        const Int8 unfinished = duration < to - time;
        unsigned accepted = active;
        unsigned next = 0;
        Float8 nextTime = time, nextDuration = duration;
        if (__builtin_expect(anyOf((rejected | unfinished) & maskOf(active)), 0)) {
            for (int i = 0; i < kLanes; ++i) {
                const unsigned lane = 1u << i;
                if (!(active & lane)) continue;
                // The estimate falls with the fourth power of the duration; aim slightly below the tolerance.
                const float ratio2 = tolerance2 / std::max(error2[i], 1e-12f * tolerance2);
                const float root = __builtin_sqrtf(__builtin_sqrtf(__builtin_sqrtf(ratio2)));
                const float wanted = duration[i] * std::clamp(0.9f * root, 0.2f, 4.0f);
                if (rejected[i]) {
                    accepted &= ~lane;
                    next |= lane;
                    nextDuration[i] = std::max(wanted, pathline::kMinDuration);
                } else if (!unfinished[i]) {
                    batch.arrived |= lane;
                } else if (covers(field.domain(), end.lane(i))) {
                    next |= lane;
                    nextTime[i] = time[i] + duration[i];
                    nextDuration[i] =
                        std::min(std::max(std::min(wanted, pathline::strideLimit(k5.lane(i))), pathline::kMinDuration),
                                 to - nextTime[i]);
                }
            }
        } else {
            batch.arrived |= active;
        }
        if (accepted != 0) {
            batch.segments.push_back({start, end, k1, k5, time, duration, accepted});
            batch.position = select(maskOf(accepted), end, start);
            batch.slope = select(maskOf(accepted), k5, k1);
        }
        time = nextTime;
        duration = nextDuration;
        active = next;
    }
}

/// The voxels on a batch's paths: samples at the middles of equal pieces of each segment, so that their mean is the
/// segment's.
struct PathSamples {
    /// One sample of each lane, as the code of a WindowVoxel; far ones are indices in `far`.
    struct Row {
        Int8 code;
        [[nodiscard]] VDBLIC_INLINE WindowVoxel voxel(int lane) const { return {code[lane]}; }
    };
    /// The samples on a segment: those of lane m are rows[firstRow + j].code[m], 0 ≤ j < count[m].
    struct Run {
        unsigned lanes;
        std::size_t firstRow;
        Int8 count;
        Int8 early; ///< number of samples before `until`
    };
    /// A voxel of a domain.
    struct Voxel {
        int leaf; ///< −1 where there is none
        unsigned offset;
    };

    std::vector<Run> runs;
    std::vector<Row> rows;
    std::vector<Voxel> far; ///< the samples outside the window

    /// The voxel of a sample, near or far. @param window of the sampling
    [[nodiscard]] VDBLIC_INLINE Voxel find(WindowVoxel sample, const LeafWindow& window) const
    {
        return sample.isFar() ? far[sample.farIndex()]
                              : Voxel{window.leaves[std::size_t(sample.slot())], sample.offset()};
    }
};

/// Sample the paths of a batch.
///
/// @param window  that the samples' codes refer to
/// @param spacing largest distance between samples along the path [voxels]
/// @param until   samples before this time count as early, as a fraction of the time step
/// Cubic Hermite dense output: Hairer, Nørsett & Wanner, Solving ODEs I, II.6. Arc length assumes that speed is linear
/// in time over the segment.
VDBLIC_INLINE void samplePaths(const PathBatch& batch, const Domain& domain, const LeafWindow& window, float spacing,
                               float until, PathSamples& samples)
{
    // The least speed avoids a division by zero for paths at rest; only an overflowed velocity needs more samples.
    constexpr float kLeastSpeed = 1e-3f, kMostSamples = 1024;
    samples.runs.clear();
    samples.far.clear();
    std::size_t rows = 0;
    for (const Segment& segment : batch.segments) {
        const Vector8 m0 = segment.startSlope * segment.duration, m1 = segment.endSlope * segment.duration;
        const Vector8 chord = segment.end - segment.start;
        const Vector8 c2 = chord * 3.0f - m0 * 2.0f - m1, c3 = m0 + m1 - chord * 2.0f;
        const Vector8 c0 = {segment.start.x + 0.5f, segment.start.y + 0.5f, segment.start.z + 0.5f};
        const Float8 speed0 = squareRoots(squaredLength(m0)) + kLeastSpeed;
        const Float8 speed1 = squareRoots(squaredLength(m1)) + kLeastSpeed;
        const Float8 arc = (speed0 + speed1) * 0.5f, chordLength = squareRoots(squaredLength(chord));
        const Float8 wanted = (arc > chordLength ? arc : chordLength) * (1 / spacing);
        const Float8 pieces = wanted < kMostSamples ? wanted : broadcast8(kMostSamples);
        const Int8 whole = __builtin_convertvector(pieces, Int8);
        const Int8 taken = maskOf(segment.lanes);
        const Int8 count = (whole - (__builtin_convertvector(whole, Float8) < pieces)) & taken; // true is −1
        const Float8 pieceLength = arc / __builtin_convertvector(count, Float8);
        const Float8 square0 = speed0 * speed0, gain = (speed1 - speed0) * 2.0f;

        const pathline::Offsets offsets(chord, chordLength);
        int most = 0;
        for (int i = 0; i < kLanes; ++i)
            most = std::max(most, count[i]);
        if (samples.rows.size() < rows + std::size_t(most)) samples.rows.resize(2 * (rows + std::size_t(most)));
        Int8 early{};
        for (int j = 0; j < most; ++j) {
            const Float8 s = pieceLength * (float(j) + 0.5f);
            const Float8 u = s * 2.0f / (squareRoots(square0 + gain * s) + speed0);
            const Vector8& offset = offsets.of[j % pathline::Offsets::kCount];
            const Int8 x = floorToInt(((u * c3.x + c2.x) * u + m0.x) * u + (c0.x + offset.x));
            const Int8 y = floorToInt(((u * c3.y + c2.y) * u + m0.y) * u + (c0.y + offset.y));
            const Int8 z = floorToInt(((u * c3.z + c2.z) * u + m0.z) * u + (c0.z + offset.z));
            const Int8 valid = count > j;
            const Int8 slots = window.slots(x, y, z);
            Int8 code = WindowVoxel::encode(slots, x, y, z);
            early -= valid & (u * segment.duration + segment.time < until);
            if (__builtin_expect(anyOf(valid & (slots == LeafWindow::kElsewhere)), 0)) {
                for (int i = 0; i < kLanes; ++i) {
                    if (!valid[i] || slots[i] != LeafWindow::kElsewhere) continue;
                    const Int4 voxel = {x[i], y[i], z[i], 0};
                    code[i] = WindowVoxel::encodeFar(samples.far.size());
                    samples.far.push_back({domain.findLeaf(voxel), Domain::offset(voxel)});
                }
            }
            samples.rows[rows + std::size_t(j)].code = code;
        }
        samples.runs.push_back({segment.lanes, rows, count, early});
        rows += std::size_t(most);
    }
}

} // namespace vdblic
