#include "methods/auflic/literal_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <map>
#include <optional>

namespace vdblic::test {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

float mix(float a, float b, float t)
{
    return a + (b - a) * t;
}

float clampToUnit(float value)
{
    return std::clamp(value, 0.0f, 1.0f);
}

/// The velocity at the centre of a texture voxel, in texture voxels per step; 0 where there is none.
Vec3f velocityOfVoxel(const VelocityFrame& frame, const Coord& voxel)
{
    const openvdb::Vec3STree& values = frame.values->tree();
    Vec3f value(0);
    if (frame.domain.refinement.isNone()) return values.probeValue(voxel, value) ? value : Vec3f(0);
    Coord cell;
    Vec3f fraction, factors;
    for (int axis = 0; axis < 3; ++axis) {
        factors[axis] = float(frame.domain.refinement.factors[std::size_t(axis)]);
        const float scale = 1 / factors[axis], coarse = float(voxel[axis]) * scale + (0.5f * scale - 0.5f);
        cell[axis] = int(std::floor(coarse));
        fraction[axis] = coarse - std::floor(coarse);
    }
    const auto weighted = [](const std::array<float, 4>& a, const std::array<float, 4>& b, float t) {
        std::array<float, 4> result{};
        for (std::size_t i = 0; i < 4; ++i)
            result[i] = a[i] * (1 - t) + b[i] * t;
        return result;
    };
    const auto corner = [&](int x, int y, int z) {
        const bool isOn = values.probeValue(cell.offsetBy(x, y, z), value);
        return isOn ? std::array{value[0], value[1], value[2], 1.0f} : std::array<float, 4>{};
    };
    const auto alongY = [&](int x, int z) { return weighted(corner(x, 0, z), corner(x, 1, z), fraction[1]); };
    const auto alongX = [&](int z) { return weighted(alongY(0, z), alongY(1, z), fraction[0]); };
    const std::array<float, 4> sum = weighted(alongX(0), alongX(1), fraction[2]);
    if (!(sum[3] > 0)) return Vec3f(0);
    return {sum[0] / sum[3] * factors[0], sum[1] / sum[3] * factors[1], sum[2] / sum[3] * factors[2]};
}

/// Filters voxel by voxel.
class Feedback {
  public:
    Feedback(const LiteralField& field, const LeafValues<float>& texture, const NoiseField& noise,
             const FeedbackParams& params, std::uint64_t step)
        : mField(field), mVoxels(field.start().domain.texture->topology()), mNoise(noise), mParams(params), mStep(step),
          mSharp(*field.start().domain.texture, 0.0f)
    {
        const openvdb::FloatTree::Ptr sharp = mSharp.tree();
        for (auto voxel = sharp->beginValueOn(); voxel; ++voxel)
            voxel.setValue(sharpened(*texture.tree(), voxel.getCoord()));
    }

    [[nodiscard]] std::int32_t at(const Coord& voxel) const
    {
        const Vec3f centre(voxel.asVec3s()), displacement = velocityOfVoxel(mField.end(), voxel);
        if (const auto brought = entering(voxel, centre - displacement)) return *brought;
        // Half a step back, along the velocity a quarter of a step back.
        const Vec3f way = mField.at(centre - displacement * 0.25f, 0.75f).value_or(displacement);
        const float carried = sharpAt(centre - way * 0.5f).value_or(sharpAt(centre).value());
        constexpr float kMaxGain = 16;
        const Moments around = contrastAround(voxel);
        const float gain = mParams.deviation / std::max(around.deviation, mParams.deviation / kMaxGain);
        const float restored = clampToUnit(0.5f + gain * (carried - around.mean));
        const float original = float(mNoise.at(voxel)) / 65535.0f;
        return std::int32_t(clampToUnit(restored + mParams.noiseShare * (original - restored)) * 65535.0f + 0.5f);
    }

  private:
    struct Moments {
        float mean, deviation;
    };

    /// c + s · (c − mean of the neighbours that are there).
    [[nodiscard]] float sharpened(const openvdb::FloatTree& texture, const Coord& voxel) const
    {
        // Sums along z of sums along y would round otherwise than the engine's: z first, then y, then x.
        const auto sum = [&](const auto& valueOf) {
            const auto alongZ = [&](int x, int y) {
                return valueOf(voxel.offsetBy(x, y, -1)) + valueOf(voxel.offsetBy(x, y, 0)) +
                       valueOf(voxel.offsetBy(x, y, 1));
            };
            const auto alongY = [&](int x) { return alongZ(x, -1) + alongZ(x, 0) + alongZ(x, 1); };
            return alongY(-1) + alongY(0) + alongY(1);
        };
        const float centre = texture.getValue(voxel);
        const float count = sum([&](const Coord& at) { return mVoxels.isValueOn(at) ? 1.0f : 0.0f; }) - 1;
        const float others = sum([&](const Coord& at) { return texture.getValue(at); }) - centre;
        return centre + mParams.sharpen * (centre - (count > 0 ? others / count : centre));
    }

    /// Trilinear between the voxels that are there.
    [[nodiscard]] std::optional<float> sharpAt(const Vec3f& position) const
    {
        const std::optional<Vec3f> place = placeInBlocks(mVoxels, position);
        if (!place) return std::nullopt;
        const Coord cell(int(std::floor((*place)[0])), int(std::floor((*place)[1])), int(std::floor((*place)[2])));
        const Vec3f fraction = *place - Vec3f(cell.asVec3s());
        const float weight = trilinear(
            fraction, [&](int x, int y, int z) { return mVoxels.isValueOn(cell.offsetBy(x, y, z)) ? 1.0f : 0.0f; });
        const float value =
            trilinear(fraction, [&](int x, int y, int z) { return mSharp.tree()->getValue(cell.offsetBy(x, y, z)); });
        return weight > 0 ? std::optional(value / weight) : std::nullopt;
    }

    /// Count, sum and sum of squares of a block of 4³ voxels.
    [[nodiscard]] const std::array<float, 3>& sumsOf(const Coord& first) const
    {
        const auto [block, isNew] = mBlocks.try_emplace(first);
        std::array<float, 3>& sums = block->second;
        if (!isNew) return sums;
        for (int i = 0; i < 64; ++i) {
            const Coord voxel = first.offsetBy(i >> 4, i >> 2 & 3, i & 3);
            const float value = mSharp.tree()->getValue(voxel);
            if (!mVoxels.isValueOn(voxel)) continue;
            sums[0] += 1;
            sums[1] += value;
            sums[2] += value * value;
        }
        return sums;
    }

    /// Interpolated between the centres of the blocks.
    [[nodiscard]] Moments contrastAround(const Coord& voxel) const
    {
        Coord first;
        Vec3f fraction;
        for (int axis = 0; axis < 3; ++axis) {
            const float block = (float(voxel[axis]) - 1.5f) / 4;
            first[axis] = 4 * int(std::floor(block));
            fraction[axis] = block - std::floor(block);
        }
        std::array<std::array<float, 3>, 8> corners;
        for (int i = 0; i < 8; ++i)
            corners[std::size_t(i)] = sumsOf(first.offsetBy(4 * (i >> 2), 4 * (i >> 1 & 1), 4 * (i & 1)));
        std::array<float, 3> sums{};
        for (std::size_t n = 0; n < 3; ++n) {
            const auto alongY = [&](std::size_t x, std::size_t z) {
                return mix(corners[4 * x + z][n], corners[4 * x + 2 + z][n], fraction[1]);
            };
            const auto alongX = [&](std::size_t z) { return mix(alongY(0, z), alongY(1, z), fraction[0]); };
            sums[n] = mix(alongX(0), alongX(1), fraction[2]);
        }
        const float mean = sums[1] / sums[0];
        return {mean, std::sqrt(std::max(sums[2] / sums[0] - mean * mean, 0.0f))};
    }

    /// The noise that fluid brings which was outside a step ago; nothing if the voxel keeps what is carried to it.
    [[nodiscard]] std::optional<std::int32_t> entering(const Coord& voxel, const Vec3f& before) const
    {
        const Coord cell(int(std::floor(before[0])), int(std::floor(before[1])), int(std::floor(before[2])));
        bool isInside = true;
        const float stayed = trilinear(before - Vec3f(cell.asVec3s()), [&](int x, int y, int z) {
            const bool isOn = mVoxels.isValueOn(cell.offsetBy(x, y, z));
            isInside = isInside && isOn;
            return isOn ? 1.0f : 0.0f;
        });
        if (isInside || !(stayed < 1) || !mNoise.fromOutside(voxel, mStep, stayed)) return std::nullopt;
        // The age of the entry, by bisection of the way to a sixteenth of a voxel.
        const Vec3f centre(voxel.asVec3s()), path = before - centre;
        float inside = mField.covers(before) ? 1.0f : 0.0f, outside = 1;
        while ((outside - inside) * std::sqrt(path.dot(path)) > 1.0f / 16 && outside - inside > 1e-6f) {
            const float middle = 0.5f * (inside + outside);
            (mField.covers(centre + path * middle) ? inside : outside) = middle;
        }
        const Coord entry = voxelAround(centre + path * inside);
        constexpr float kShare = 0.4f, kUniformDeviation = 0.2887f;
        const double time = double(mStep + 1) - inside;
        const float gain = kShare * mParams.deviation / kUniformDeviation;
        return std::int32_t(std::lround(clampToUnit(0.5f + gain * mNoise.entering(entry, time, 2)) * 65535.0f));
    }

    const LiteralField& mField;
    const openvdb::MaskTree& mVoxels;
    const NoiseField& mNoise;
    const FeedbackParams& mParams;
    std::uint64_t mStep;
    LeafValues<float> mSharp;
    mutable std::map<Coord, std::array<float, 3>> mBlocks; // those asked for
};

} // namespace

LeafValues<float> literalMeanAlongFlow(const VelocityFrame& frame, const LeafValues<float>& texture)
{
    constexpr int kTaps = 2;
    const openvdb::MaskTree& voxels = frame.domain.texture->topology();
    LeafValues<float> result(*frame.domain.texture, 0.0f);
    const openvdb::FloatTree::Ptr tree = result.tree();
    for (auto voxel = tree->beginValueOn(); voxel; ++voxel) {
        const Coord at = voxel.getCoord(), leaf = at & ~7;
        const Vec3f velocity = velocityOfVoxel(frame, at);
        const float squared = velocity.dot(velocity);
        const bool moves = squared > 1e-12f && squared < 1e30f;
        const Vec3f direction = moves ? velocity * (1 / std::sqrt(squared)) : Vec3f(0);
        float sum = texture.tree()->getValue(at) * float(kTaps + 1), weights = float(kTaps + 1);
        for (const int tap : {-2, -1, 1, 2}) {
            // Counted from the leaf's first voxel: the same rounding wherever the leaf is.
            const Vec3f place = Vec3f((at - leaf).asVec3s()) + direction * float(tap);
            const Coord cell(int(std::floor(place[0])), int(std::floor(place[1])), int(std::floor(place[2])));
            const Vec3f fraction = place - Vec3f(cell.asVec3s());
            const auto between = [&](const auto& valueOf) {
                const auto alongX = [&](int y, int z) {
                    const Coord low = leaf + cell.offsetBy(0, y, z);
                    return mix(valueOf(low), valueOf(low.offsetBy(1, 0, 0)), fraction[0]);
                };
                const auto alongY = [&](int z) { return mix(alongX(0, z), alongX(1, z), fraction[1]); };
                return mix(alongY(0), alongY(1), fraction[2]);
            };
            const float covered = between([&](const Coord& corner) { return voxels.isValueOn(corner) ? 1.0f : 0.0f; });
            if (!(covered > 0)) continue;
            const auto weight = float(kTaps + 1 - std::abs(tap));
            sum += between([&](const Coord& corner) { return texture.tree()->getValue(corner); }) / covered * weight;
            weights += weight;
        }
        voxel.setValue(sum / weights);
    }
    return result;
}

LeafValues<std::int32_t> literalFeedForward(const LiteralField& field, const LeafValues<float>& texture,
                                            const Domain& next, const NoiseField& noise, const FeedbackParams& params,
                                            std::uint64_t step)
{
    const Feedback feedback(field, texture, noise, params, step);
    LeafValues<std::int32_t> input(next, 0);
    const auto tree = input.tree();
    for (auto voxel = tree->beginValueOn(); voxel; ++voxel) {
        const Coord at = voxel.getCoord();
        voxel.setValue(field.start().domain.texture->topology().isValueOn(at) ? feedback.at(at) : noise.at(at));
    }
    return input;
}

} // namespace vdblic::test
