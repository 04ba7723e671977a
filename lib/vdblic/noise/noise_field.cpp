#include "vdblic/noise/noise_field.h"

#include "vdblic/field/domain_rows.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"
#include "vdblic/noise/noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace vdblic {
namespace {

std::int32_t noiseOf(float value)
{
    return std::int32_t(std::lround(std::clamp(value, 0.0f, 1.0f) * float(kNoiseMax)));
}

VDBLIC_KERNEL void fillGenerated(const openvdb::Coord& origin, std::uint32_t seed, std::int32_t* values)
{
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const LeafVoxel first = LeafVoxel::ofRow(row);
        const std::uint64_t column = noiseColumn(origin[0] + first.x, origin[1] + first.y, seed);
        storeRow(noiseRow(column, origin[2]), values, row);
    }
}

} // namespace

void NoiseField::fill(const openvdb::Coord& origin, std::int32_t* values) const
{
    fillGenerated(origin, mSeed, values);
    if (!mGrid) return;
    if (const auto* leaf = mGrid->tree().probeConstLeaf(origin)) {
        for (auto value = leaf->cbeginValueOn(); value; ++value)
            values[value.pos()] = noiseOf(*value);
    } else if (float constant = 0; mGrid->tree().probeValue(origin, constant)) {
        std::fill_n(values, LeafVoxel::kCount, noiseOf(constant));
    }
}

std::int32_t NoiseField::at(const openvdb::Coord& voxel) const
{
    if (float value = 0; mGrid && mGrid->tree().probeValue(voxel, value)) return noiseOf(value);
    return noiseValue(voxel[0], voxel[1], voxel[2], mSeed);
}

VDBLIC_KERNEL void NoiseField::atCorners(const openvdb::Coord& first, int edge, std::int32_t* values) const
{
    if (!mGrid) {
        const Int8 generated = noiseCorners(first[0], first[1], first[2], edge, mSeed);
        std::memcpy(values, &generated, sizeof generated);
        return;
    }
    for (int corner = 0; corner < 8; ++corner)
        values[corner] = at(first.offsetBy(edge * (corner >> 2), edge * (corner >> 1 & 1), edge * (corner & 1)));
}

std::int32_t NoiseField::ofStep(const openvdb::Coord& voxel, std::uint64_t number) const
{
    const auto seed = std::uint32_t(mixBits(std::uint64_t(mSeed) << 32 ^ (number + 1)) >> 32);
    return noiseValue(voxel[0], voxel[1], voxel[2], seed);
}

float NoiseField::entering(const openvdb::Coord& voxel, double time, int span) const
{
    const double first = time - 0.5 * span, frame = std::floor(first);
    const auto part = float(first - frame); // of the first frame, before the span
    float sum = 0, squares = 0;
    for (int i = 0; i <= span; ++i) {
        const float weight = i == 0 ? 1 - part : i == span ? part : 1;
        sum += weight * (float(ofStep(voxel, 2 * std::uint64_t(std::int64_t(frame) + i))) / float(kNoiseMax) - 0.5f);
        squares += weight * weight;
    }
    return sum / std::sqrt(squares);
}

bool NoiseField::fromOutside(const openvdb::Coord& voxel, std::uint64_t step, float stayed) const
{
    return (float(ofStep(voxel, 2 * step + 1)) + 0.5f) / float(kNoiseMax + 1) > stayed;
}

LeafValues<std::int32_t> noiseInput(const Domain& domain, const NoiseField& noise)
{
    LeafValues<std::int32_t> input(domain, 0, domain.own());
    forLeaves(domain.own(), [&](std::size_t leaf) { noise.fill(domain.origin(leaf), input[leaf]); });
    return input;
}

LeafValues<float> noiseValues(const Domain& domain, const NoiseField& noise, Domain::Leaves on)
{
    LeafValues<float> values(domain, 0.0f, on);
    forLeaves(on, [&](std::size_t leaf) {
        std::array<std::int32_t, LeafVoxel::kCount> all;
        noise.fill(domain.origin(leaf), all.data());
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel)
            values[leaf][voxel.pos()] = float(all[voxel.pos()]);
    });
    return values;
}

} // namespace vdblic
