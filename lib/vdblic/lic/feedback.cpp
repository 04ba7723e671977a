#include "vdblic/lic/feedback.h"

#include "vdblic/core/errors.h"
#include "vdblic/lic/neighbourhood.h"
#include "vdblic/lic/noise.h"
#include "vdblic/lic/scatter.h"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>

namespace vdblic {
namespace {

constexpr int kDim = Domain::Leaf::DIM;
constexpr float kFull = float(kNoiseMax);
constexpr float kMaxGain = 16;

std::int32_t toFixed(float value)
{
    return std::int32_t(std::clamp(value, 0.0f, 1.0f) * kFull + 0.5f);
}

/// c + s (c − mean of the valid neighbours) for every voxel.
LeafValues<float> sharpened(const Domain& domain, const LeafValues<float>& texture, float strength)
{
    LeafValues<float> result(domain, 0.0f);
    tbb::parallel_for(std::size_t(0), domain.leafCount(), [&](std::size_t leaf) {
        Neighbourhood around = gatherNeighbourhood(domain, texture, domain.origin(leaf));
        sumNeighbours(around.value);
        sumNeighbours(around.valid);
        for (int i = 0; i < Domain::kLeafVoxels; ++i) {
            const int x = i >> 6, y = i >> 3 & 7, z = i & 7;
            const auto at = Neighbourhood::index(x, y, z);
            const float centre = texture[leaf][i];
            const float neighbours = around.valid[at] - 1;
            const float mean = neighbours > 0 ? (around.value[at] - centre) / neighbours : centre;
            result[leaf][i] = centre + strength * (centre - mean);
        }
    });
    return result;
}

// Contrast is taken over blocks of 4³ voxels and their neighbours: wide enough to tell contrast, narrow enough that no
// feature grows broader than a few voxels.
constexpr int kBlock = 4;
constexpr int kBlocks = kDim / kBlock; // of a leaf, along each axis

/// Number, sum and sum of squares of a block's values.
struct Moments {
    double count = 0, sum = 0, squares = 0;
};
using LeafMoments = std::array<Moments, kBlocks * kBlocks * kBlocks>;

constexpr int blockOf(int x, int y, int z)
{
    return (x / kBlock * kBlocks + y / kBlock) * kBlocks + z / kBlock;
}

std::vector<LeafMoments> momentsOf(const Domain& domain, const LeafValues<float>& values)
{
    std::vector<LeafMoments> moments(domain.leafCount());
    tbb::parallel_for(std::size_t(0), domain.leafCount(), [&](std::size_t leaf) {
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel) {
            const double value = values[leaf][voxel.pos()];
            const int offset = int(voxel.pos());
            Moments& block = moments[leaf][std::size_t(blockOf(offset >> 6, offset >> 3 & 7, offset & 7))];
            block.count += 1;
            block.sum += value;
            block.squares += value * value;
        }
    });
    return moments;
}

/// Mean and standard deviation around a voxel: the moments of the nearest blocks, weighted linearly by the distance of
/// their centres.
class LocalContrast {
  public:
    LocalContrast(const Domain& domain, const std::vector<LeafMoments>& moments, const openvdb::Coord& origin)
    {
        for (int part = 0; part < kAround * kAround * kAround; ++part) {
            const Int4 there = {origin[0] + (part / (kAround * kAround) - 1) * kBlock,
                                origin[1] + (part / kAround % kAround - 1) * kBlock,
                                origin[2] + (part % kAround - 1) * kBlock, 0};
            if (const int leaf = domain.findLeaf(there); leaf >= 0) {
                mAround[std::size_t(part)] =
                    moments[std::size_t(leaf)][std::size_t(blockOf(there[0] & 7, there[1] & 7, there[2] & 7))];
            }
        }
    }

    struct Contrast {
        float mean, deviation;
    };
    [[nodiscard]] Contrast at(int offset) const
    {
        const Axis x(offset >> 6), y(offset >> 3 & 7), z(offset & 7);
        Moments m;
        for (int corner = 0; corner < 8; ++corner) {
            const int i = corner >> 2, j = corner >> 1 & 1, k = corner & 1;
            const Moments& block =
                mAround[std::size_t(((x.first + i) * kAround + y.first + j) * kAround + z.first + k)];
            const double weight = x.weight[i] * y.weight[j] * z.weight[k];
            m.count += weight * block.count;
            m.sum += weight * block.sum;
            m.squares += weight * block.squares;
        }
        const double mean = m.sum / m.count;
        return {float(mean), float(std::sqrt(std::max(0.0, m.squares / m.count - mean * mean)))};
    }

  private:
    static constexpr int kAround = kBlocks + 2; // the leaf's blocks and one before and after, along each axis

    /// The two blocks whose centres enclose a voxel along one axis.
    struct Axis {
        explicit Axis(int voxel) : first((voxel + kBlock / 2) / kBlock)
        {
            weight[1] = (voxel + 0.5 + kBlock / 2) / kBlock - first;
            weight[0] = 1 - weight[1];
        }
        int first;
        double weight[2];
    };
    std::array<Moments, kAround * kAround * kAround> mAround{};
};

/// The top bit from the texture, the rest from the noise; values near the ends are stretched to them.
float jitterBits(float texture, float noise)
{
    const float value = (texture > 0.5f ? 0.5f : 0.0f) + std::fmod(noise, 0.5f);
    return value > 0.9f ? 1.0f : value < 0.1f ? 0.0f : value;
}

/// Trilinear interpolation of a domain's values, over the corners that are in the domain.
class Interpolator {
  public:
    Interpolator(const Domain& domain, const LeafValues<float>& values) : mDomain(domain), mValues(values) {}

    struct Sample {
        float value;    ///< mean of the corners in the domain; 0 if there are none
        float coverage; ///< their share of the weights
    };
    [[nodiscard]] Sample at(Float4 position) const
    {
        const Int4 base = floorToInt(position);
        const Float4 fraction = position - __builtin_convertvector(base, Float4);
        float sum = 0, coverage = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const Int4 step = {corner >> 2, corner >> 1 & 1, corner & 1, 0};
            float weight = 1;
            for (int axis = 0; axis < 3; ++axis)
                weight *= step[axis] ? fraction[axis] : 1 - fraction[axis];
            const Int4 voxel = base + step;
            const int leaf = weight > 0 ? mDomain.findLeaf(voxel) : -1;
            if (leaf < 0 || !mDomain.isActive(leaf, Domain::offset(voxel))) continue;
            sum += weight * mValues[std::size_t(leaf)][Domain::offset(voxel)];
            coverage += weight;
        }
        return {coverage > 0 ? sum / coverage : 0, coverage};
    }

  private:
    const Domain& mDomain;
    const LeafValues<float>& mValues;
};

} // namespace

Jitter parseJitter(std::string_view text)
{
    if (text == "mix") return Jitter::kMix;
    if (text == "bits") return Jitter::kBits;
    throw ParameterError(fmt::format("jitter '{}' is neither mix nor bits", text));
}

std::string_view toString(Jitter jitter)
{
    return jitter == Jitter::kMix ? "mix" : "bits";
}

void FeedbackParams::validate() const
{
    if (!(sharpen >= 0 && sharpen <= 100))
        throw ParameterError(fmt::format("sharpening {} must lie in 0 to 100", sharpen));
    if (!(noiseShare >= 0 && noiseShare <= 1)) {
        throw ParameterError(fmt::format("noise share {} must lie in 0 to 1", noiseShare));
    }
    if (!(deviation > 0 && deviation <= 0.5f)) {
        throw ParameterError(fmt::format("deviation {} must be above 0 and at most 0.5", deviation));
    }
}

void NoiseField::fill(const openvdb::Coord& origin, std::int32_t* values) const
{
    for (int i = 0; i < Domain::kLeafVoxels; ++i) {
        const openvdb::Coord at = origin + Domain::Leaf::offsetToLocalCoord(openvdb::Index(i));
        values[i] = noiseValue(at[0], at[1], at[2], mSeed);
    }
    if (!mGrid) return;
    if (const auto* leaf = mGrid->tree().probeConstLeaf(origin)) {
        for (auto value = leaf->cbeginValueOn(); value; ++value)
            values[value.pos()] = toFixed(*value);
    } else if (float tile = 0; mGrid->tree().probeValue(origin, tile)) {
        std::fill_n(values, Domain::kLeafVoxels, toFixed(tile));
    }
}

std::int32_t NoiseField::ofStep(const openvdb::Coord& voxel, std::uint64_t number) const
{
    const auto seed = std::uint32_t(mixBits(std::uint64_t(mSeed) << 32 ^ (number + 1)) >> 32);
    return noiseValue(voxel[0], voxel[1], voxel[2], seed);
}

std::int32_t NoiseField::entering(const openvdb::Coord& voxel, std::uint64_t step) const
{
    return ofStep(voxel, 2 * step);
}

bool NoiseField::fromOutside(const openvdb::Coord& voxel, std::uint64_t step, float stayed) const
{
    return (float(ofStep(voxel, 2 * step + 1)) + 0.5f) / (kFull + 1) > stayed;
}

LeafValues<std::int32_t> noiseInput(const Domain& domain, const NoiseField& noise)
{
    LeafValues<std::int32_t> input(domain, 0);
    tbb::parallel_for(std::size_t(0), domain.leafCount(),
                      [&](std::size_t leaf) { noise.fill(domain.origin(leaf), input[leaf]); });
    return input;
}

LeafValues<float> convolve(const Domain& domain, const LeafValues<std::int64_t>& accumulator,
                           const LeafValues<std::int32_t>& input)
{
    LeafValues<float> texture(domain, 0.0f);
    tbb::parallel_for(std::size_t(0), domain.leafCount(), [&](std::size_t leaf) {
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel) {
            const auto hits = std::uint64_t(accumulator[leaf][voxel.pos()]);
            const float value = Hits::count(hits) > 0 ? float(double(Hits::sum(hits)) / double(Hits::count(hits)))
                                                      : float(input[leaf][voxel.pos()]);
            texture[leaf][voxel.pos()] = value / kFull;
        }
    });
    return texture;
}

LeafValues<std::int32_t> feedForward(const VelocityField& field, const LeafValues<float>& output, const Domain& next,
                                     const NoiseField& noise, const FeedbackParams& params, std::uint64_t step)
{
    const Domain& domain = field.domain();
    const LeafValues<float> sharp = sharpened(domain, output, params.sharpen);
    const Interpolator texture(domain, sharp);
    const std::vector<LeafMoments> moments = momentsOf(domain, sharp);

    LeafValues<std::int32_t> input(next, 0);
    tbb::parallel_for(std::size_t(0), next.leafCount(), [&](std::size_t leaf) {
        std::int32_t* values = input[leaf];
        const openvdb::Coord origin = next.origin(leaf);
        noise.fill(origin, values);
        const int from = domain.findLeaf(Int4{origin[0], origin[1], origin[2], 0});
        if (from < 0) return;
        const LocalContrast contrast(domain, moments, origin);
        for (auto voxel = domain.mask(std::size_t(from)).beginOn(); voxel; ++voxel) {
            const openvdb::Coord at = origin + Domain::Leaf::offsetToLocalCoord(voxel.pos());
            const Float4 centreOfVoxel = {float(at[0]), float(at[1]), float(at[2]), 0};
            const Float4 way = field.sample(centreOfVoxel, 1, Float4{});
            const float original = float(values[voxel.pos()]) / kFull;
            // The part of the voxel's fluid that was in the domain a step ago.
            const float stayed = texture.at(centreOfVoxel - way).coverage;
            const auto [there, known] = texture.at(centreOfVoxel - way * 0.5f);
            const float value = known > 0 ? there : sharp[std::size_t(from)][voxel.pos()];
            if (noise.fromOutside(at, step, stayed)) {
                values[voxel.pos()] = noise.entering(at, step);
            } else if (params.jitter == Jitter::kBits) {
                values[voxel.pos()] = toFixed(jitterBits(value, original));
            } else {
                const auto [mean, deviation] = contrast.at(int(voxel.pos()));
                // Where there is next to no contrast there is none to restore.
                const float gain = params.deviation / std::max(deviation, params.deviation / kMaxGain);
                const float restored = std::clamp(0.5f + gain * (value - mean), 0.0f, 1.0f);
                values[voxel.pos()] = toFixed(restored + params.noiseShare * (original - restored));
            }
        }
    });
    return input;
}

} // namespace vdblic
