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
VDBLIC_INLINE Float4 weighted(const Taps& taps, const Float4* values, std::size_t stride)
{
    Float4 sum{};
    for (std::size_t tap = 0; tap < 4; ++tap)
        sum += values[tap * stride] * taps.weights[tap];
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
    const auto sizeX = std::size_t(mSize[0]), sizeY = std::size_t(mSize[1]), sizeZ = std::size_t(mSize[2]);
    mBlock.resize(sizeX * sizeY * sizeZ);
    mLines.resize(sizeX * sizeY * Bricks::kDim);
    mPlanes.resize(sizeX * Bricks::kDim * Bricks::kDim);
}

void CubicBrick::fill(const Velocities<Space::kTexture, Per::kStep>& velocities, Record* records, int lane)
{
    gather(velocities);
    constexpr std::size_t kDim = Bricks::kDim;
    const auto sizeX = std::size_t(mSize[0]), sizeY = std::size_t(mSize[1]), sizeZ = std::size_t(mSize[2]);
    for (std::size_t line = 0; line < sizeX * sizeY; ++line) {
        for (std::size_t z = 0; z < kDim; ++z) {
            const Taps& taps = mTaps[2][z];
            mLines[line * kDim + z] = weighted(taps, &mBlock[line * sizeZ + std::size_t(taps.first)], 1);
        }
    }
    for (std::size_t x = 0; x < sizeX; ++x) {
        for (std::size_t y = 0; y < kDim; ++y) {
            const Taps& taps = mTaps[1][y];
            for (std::size_t z = 0; z < kDim; ++z) {
                mPlanes[(x * kDim + y) * kDim + z] =
                    weighted(taps, &mLines[(x * sizeY + std::size_t(taps.first)) * kDim + z], kDim);
            }
        }
    }
    for (std::size_t x = 0; x < kDim; ++x) {
        const Taps& taps = mTaps[0][x];
        for (std::size_t yz = 0; yz < kDim * kDim; ++yz) {
            Float4 record = weighted(taps, &mPlanes[std::size_t(taps.first) * kDim * kDim + yz], kDim * kDim);
            const float coverage = record[3];
            record *= coverage;
            record[3] = coverage;
            *reinterpret_cast<Float4*>(records[x * kDim * kDim + yz].values + lane) = record;
        }
    }
}

/// Load the block's velocities and their coverage from the tree.
void CubicBrick::gather(const Velocities<Space::kTexture, Per::kStep>& velocities)
{
    const openvdb::tree::ValueAccessor<const openvdb::Vec3STree> values(velocities.stored);
    const openvdb::Mat3s toStep(velocities.unit.matrix);
    bool whole = true;
    for (int x = 0; x < mSize[0]; ++x) {
        for (int y = 0; y < mSize[1]; ++y) {
            for (int z = 0; z < mSize[2]; ++z) {
                openvdb::Vec3f value;
                const bool active = values.probeValue(velocities.period.wrapped(mFirst.offsetBy(x, y, z)), value);
                value = toStep * value;
                mBlock[std::size_t(index(x, y, z))] = active ? Float4{value[0], value[1], value[2], 1} : Float4{};
                whole = whole && active;
            }
        }
    }
    if (!whole) extend();
}

/// Extrapolate the velocity two voxels into voxels without a value; their coverage stays 0.
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
