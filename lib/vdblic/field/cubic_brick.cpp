#include "vdblic/field/cubic_brick.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vdblic {
namespace {

Float4 tapWeight(float velocity, float coverage)
{
    return Float4{velocity, velocity, velocity, coverage};
}

/// The sum of four values, `stride` apart, times the taps' weights.
template<typename Taps>
VDBLIC_INLINE Float4 weighted(const Taps& taps, const Float4* values, int stride)
{
    Float4 sum{};
    for (int tap = 0; tap < 4; ++tap)
        sum += values[tap * stride] * taps.weights[std::size_t(tap)];
    return sum;
}

} // namespace

CubicBrick::CubicBrick(const Refinement& refinement, const openvdb::Coord& origin)
{
    for (int axis = 0; axis < 3; ++axis) {
        auto& taps = mTaps[std::size_t(axis)];
        for (int voxel = 0; voxel < Bricks::kDim; ++voxel) {
            const float position = float(origin[axis] + voxel) * refinement.scale(axis) + refinement.shift(axis);
            const float cell = std::floor(position), f = position - cell;
            if (voxel == 0) mFirst[axis] = int(cell) - 1;
            taps[std::size_t(voxel)] = {
                int(cell) - 1 - mFirst[axis],
                {tapWeight(((2 - f) * f - 1) * f / 2, 0), tapWeight(((3 * f - 5) * f * f + 2) / 2, 1 - f),
                 tapWeight(((4 - 3 * f) * f + 1) * f / 2, f), tapWeight((f - 1) * f * f / 2, 0)}};
        }
        mSize[std::size_t(axis)] = taps.back().first + kTaps;
    }
    mBlock.resize(std::size_t(mSize[0] * mSize[1] * mSize[2]));
    mLines.resize(std::size_t(mSize[0] * mSize[1] * Bricks::kDim));
    mPlanes.resize(std::size_t(mSize[0] * Bricks::kDim * Bricks::kDim));
}

void CubicBrick::fill(const VelocityLevel& level, Record* records, int lane)
{
    gather(level);
    constexpr int kDim = Bricks::kDim;
    for (int line = 0; line < mSize[0] * mSize[1]; ++line) {
        for (int z = 0; z < kDim; ++z) {
            const Taps& taps = mTaps[2][std::size_t(z)];
            mLines[std::size_t(line * kDim + z)] =
                weighted(taps, &mBlock[std::size_t(line * mSize[2] + taps.first)], 1);
        }
    }
    for (int x = 0; x < mSize[0]; ++x) {
        for (int y = 0; y < kDim; ++y) {
            const Taps& taps = mTaps[1][std::size_t(y)];
            for (int z = 0; z < kDim; ++z) {
                mPlanes[std::size_t((x * kDim + y) * kDim + z)] =
                    weighted(taps, &mLines[std::size_t((x * mSize[1] + taps.first) * kDim + z)], kDim);
            }
        }
    }
    for (int x = 0; x < kDim; ++x) {
        const Taps& taps = mTaps[0][std::size_t(x)];
        for (int yz = 0; yz < kDim * kDim; ++yz) {
            Float4 record = weighted(taps, &mPlanes[std::size_t(taps.first * kDim * kDim + yz)], kDim * kDim);
            const float coverage = record[3];
            record *= coverage;
            record[3] = coverage;
            *reinterpret_cast<Float4*>(records[x * kDim * kDim + yz].values + lane) = record;
        }
    }
}

/// Take the block's velocities [voxels per step] and their coverage from the tree.
void CubicBrick::gather(const VelocityLevel& level)
{
    const openvdb::tree::ValueAccessor<const openvdb::Vec3STree> values(level.velocities);
    const openvdb::Mat3s toStep(level.toStep);
    bool whole = true;
    for (int x = 0; x < mSize[0]; ++x) {
        for (int y = 0; y < mSize[1]; ++y) {
            for (int z = 0; z < mSize[2]; ++z) {
                openvdb::Vec3f value;
                const bool active = values.probeValue(mFirst.offsetBy(x, y, z), value);
                value = toStep * value;
                mBlock[std::size_t(index(x, y, z))] = active ? Float4{value[0], value[1], value[2], 1} : Float4{};
                whole = whole && active;
            }
        }
    }
    if (!whole) extend();
}

/// Continue the velocity into voxels without a value, two voxels far; their coverage stays 0.
void CubicBrick::extend()
{
    std::vector<bool> known(mBlock.size());
    for (std::size_t i = 0; i < mBlock.size(); ++i)
        known[i] = mBlock[i][3] > 0;
    for (int ring = 0; ring < 2; ++ring) {
        const std::vector<bool> before = known;
        for (int x = 0; x < mSize[0]; ++x) {
            for (int y = 0; y < mSize[1]; ++y) {
                for (int z = 0; z < mSize[2]; ++z) {
                    const auto here = std::size_t(index(x, y, z));
                    if (before[here]) continue;
                    Float4 sum{};
                    float count = 0;
                    for (int i = std::max(x - 1, 0); i <= std::min(x + 1, mSize[0] - 1); ++i) {
                        for (int j = std::max(y - 1, 0); j <= std::min(y + 1, mSize[1] - 1); ++j) {
                            for (int k = std::max(z - 1, 0); k <= std::min(z + 1, mSize[2] - 1); ++k) {
                                const auto there = std::size_t(index(i, j, k));
                                if (!before[there]) continue;
                                sum += mBlock[there];
                                ++count;
                            }
                        }
                    }
                    if (count == 0) continue;
                    mBlock[here] = sum / count;
                    mBlock[here][3] = 0;
                    known[here] = true;
                }
            }
        }
    }
}

} // namespace vdblic
