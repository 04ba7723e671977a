#include "vdblic/lic/feedback.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/lic/local_contrast.h"
#include "vdblic/lic/neighbourhood.h"
#include "vdblic/lic/noise.h"
#include "vdblic/lic/scatter.h"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>

namespace vdblic {
namespace {

constexpr float kFull = float(kNoiseMax);
constexpr float kMaxGain = 16;

std::int32_t toFixed(float value)
{
    return std::int32_t(std::clamp(value, 0.0f, 1.0f) * kFull + 0.5f);
}

VDBLIC_INLINE Float8 clampToUnit(Float8 value)
{
    const Float8 atLeast0 = value > 0 ? value : Float8{};
    return atLeast0 < 1 ? atLeast0 : broadcast8(1);
}
VDBLIC_INLINE Int8 toFixed(Float8 value)
{
    return __builtin_convertvector(clampToUnit(value) * kFull + 0.5f, Int8);
}

/// c + s (c − mean of the valid neighbours) for every voxel.
LeafValues<float> sharpened(const Domain& domain, const LeafValues<float>& texture, float strength)
{
    LeafValues<float> result(domain, 0.0f);
    tbb::parallel_for(std::size_t(0), domain.leafCount(), [&](std::size_t leaf) {
        const NeighbourSums sums = sumNeighbours(domain, texture, leaf, 1);
        const Domain::Mask& mask = domain.mask(leaf);
        for (int i = 0; i < Domain::kLeafVoxels; ++i) {
            if (!mask.isOn(openvdb::Index(i))) continue;
            const float centre = texture[leaf][i];
            const float neighbours = sums.weight[std::size_t(i)] - 1;
            const float mean = neighbours > 0 ? (sums.value[std::size_t(i)] - centre) / neighbours : centre;
            result[leaf][i] = centre + strength * (centre - mean);
        }
    });
    return result;
}

/// The top bit from the texture, the rest from the noise; values near the ends are stretched to them.
float jitterBits(float texture, float noise)
{
    const float value = (texture > 0.5f ? 0.5f : 0.0f) + std::fmod(noise, 0.5f);
    return value > 0.9f ? 1.0f : value < 0.1f ? 0.0f : value;
}

/// A texture as it is and sharpened, to be sampled between voxels.
class TextureBricks {
  public:
    TextureBricks(std::shared_ptr<const Domain> domain, const LeafValues<float>& texture,
                  const LeafValues<float>& sharp)
        : mTexture(texture), mSharp(sharp)
    {
        mBricks.cover(std::move(domain));
    }

    void fill(Slabs::Leaves leaves)
    {
        mBricks.fill(leaves, [&](std::size_t leaf, BricksOf<4>::Record* records) {
            visitBrick(mBricks.domain(), leaf, [&](int record, int there, unsigned offset) {
                const auto at = std::size_t(there);
                records[record] = there < 0 ? BricksOf<4>::Record{}
                                            : BricksOf<4>::Record{{mTexture[at][offset], mSharp[at][offset], 1, 0}};
            });
        });
    }
    void release(Slabs::Leaves leaves) { mBricks.release(leaves); }

    /// Means over the corners in the domain, and their share of the weights; the means mean nothing where that is 0.
    struct Samples {
        Float8 texture, sharp, coverage;
    };
    [[nodiscard]] VDBLIC_INLINE Samples at(const LeafWindow& window, const Vector8& position, unsigned lanes) const
    {
        Float4 rows[8];
        mBricks.interpolate(window, position, lanes, rows);
        Float8 columns[4];
        transpose(rows, columns);
        return {columns[0] / columns[2], columns[1] / columns[2], columns[2]};
    }

  private:
    const LeafValues<float>&mTexture, &mSharp;
    BricksOf<4> mBricks;
};

/// The domain's share of the trilinear weights at a position.
float coverageAt(const Domain& domain, Float4 position)
{
    const Int4 base = floorToInt(position);
    const Float4 fraction = position - __builtin_convertvector(base, Float4);
    float coverage = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Int4 step = {corner >> 2, corner >> 1 & 1, corner & 1, 0};
        const auto voxel = Int4(Unsigned4(base) + Unsigned4(step)); // wraps around far outside
        const int leaf = domain.findLeaf(voxel);
        if (leaf < 0 || !domain.isActive(leaf, Domain::offset(voxel))) continue;
        float weight = 1;
        for (int axis = 0; axis < 3; ++axis)
            weight *= step[axis] ? fraction[axis] : 1 - fraction[axis];
        coverage += weight;
    }
    return coverage;
}

/// A box of voxels around a leaf that are all in the domain: as many of the leaves around as are full, or nothing.
class FullBox {
  public:
    FullBox(const Domain& domain, const LeafWindow& window)
    {
        int first[3] = {1, 1, 1}, last[3] = {1, 1, 1}; // leaves of the window along each axis
        const auto full = [&] {
            for (int x = first[0]; x <= last[0]; ++x) {
                for (int y = first[1]; y <= last[1]; ++y) {
                    for (int z = first[2]; z <= last[2]; ++z) {
                        const int leaf = window.leaves[std::size_t(LeafWindow::slot(x, y, z))];
                        if (leaf < 0 || !domain.mask(std::size_t(leaf)).isOn()) return false;
                    }
                }
            }
            return true;
        };
        if (!full()) return;
        for (int axis = 0; axis < 3; ++axis) {
            first[axis] = 0;
            if (!full()) first[axis] = 1;
            last[axis] = 2;
            if (!full()) last[axis] = 1;
        }
        for (int axis = 0; axis < 3; ++axis) {
            mFirst[axis] = float((window.first[axis] + first[axis]) * LeafVoxel::kDim);
            mLast[axis] = float((window.first[axis] + last[axis] + 1) * LeafVoxel::kDim - 1);
        }
    }

    /// Which of eight positions lie between voxels of the box.
    [[nodiscard]] VDBLIC_INLINE Int8 contains(const Vector8& p) const
    {
        return (p.x >= mFirst[0]) & (p.x < mLast[0]) & (p.y >= mFirst[1]) & (p.y < mLast[1]) & (p.z >= mFirst[2]) &
               (p.z < mLast[2]);
    }

  private:
    float mFirst[3] = {0, 0, 0}, mLast[3] = {0, 0, 0};
};

/// What nothing was before: the noise, which is its own history.
void fillWithNoise(const NoiseField& noise, const openvdb::Coord& origin, std::int32_t* input)
{
    noise.fill(origin, input);
    for (int i = 0; i < Domain::kLeafVoxels; ++i)
        input[i] = Input::pack(std::uint32_t(input[i]), std::uint32_t(input[i]));
}

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
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const std::uint64_t column =
            noiseColumn(origin[0] + LeafVoxel::ofRow(row).x, origin[1] + LeafVoxel::ofRow(row).y, mSeed);
        for (int z = 0; z < LeafVoxel::kDim; ++z)
            values[LeafVoxel::kDim * row + z] = noiseInColumn(column, origin[2] + z);
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
                      [&](std::size_t leaf) { fillWithNoise(noise, domain.origin(leaf), input[leaf]); });
    return input;
}

LeafValues<float> convolve(const Domain& domain, const LeafValues<std::int64_t>& accumulator,
                           const LeafValues<std::int32_t>& input)
{
    LeafValues<float> texture(domain, 0.0f);
    tbb::parallel_for(std::size_t(0), domain.leafCount(), [&](std::size_t leaf) {
        for (int i = 0; i < Domain::kLeafVoxels; ++i) {
            const std::int64_t word = accumulator[leaf][i];
            if (word < 0) continue;
            const std::uint64_t sum = Hits::sum(std::uint64_t(word)), count = Hits::count(std::uint64_t(word));
            const float value = count > 0 ? float(double(sum) / double(count)) : float(Input::value(input[leaf][i]));
            texture[leaf][i] = value / kFull;
        }
    });
    return texture;
}

namespace {

/// The velocities of a leaf's voxels, in voxels per step; 0 where there is none.
class LeafVelocities {
  public:
    LeafVelocities(const VelocityLevel& level, const openvdb::Coord& origin)
        : mToStep(level.toStep), mLeaf(level.velocities.probeConstLeaf(origin))
    {
        if (!mLeaf && !level.velocities.probeValue(origin, mTile)) mTile = openvdb::Vec3f(0);
    }

    /// The eight of a row along z.
    [[nodiscard]] VDBLIC_INLINE Vector8 row(int row) const
    {
        Vector8 stored{};
        for (int z = 0; z < LeafVoxel::kDim; ++z) {
            const auto offset = openvdb::Index(LeafVoxel::kDim * row + z);
            const openvdb::Vec3f value = !mLeaf                     ? mTile
                                         : mLeaf->isValueOn(offset) ? mLeaf->buffer().data()[offset]
                                                                    : openvdb::Vec3f(0);
            stored.setLane(z, Float4{value[0], value[1], value[2], 0});
        }
        const auto component = [&](int i) {
            return stored.x * mToStep(i, 0) + stored.y * mToStep(i, 1) + stored.z * mToStep(i, 2);
        };
        return {component(0), component(1), component(2)};
    }

  private:
    openvdb::Mat3s mToStep;
    const openvdb::Vec3STree::LeafNodeType* mLeaf;
    openvdb::Vec3f mTile;
};

/// What filters one leaf after another; only reads.
struct FeedForward {
    const VelocityLevel& velocities; ///< at the step's end
    const Domain& domain;
    const TextureBricks& texture;
    const LocalContrast& contrast;
    const NoiseField& noise;
    const FeedbackParams& params;
    std::uint64_t step;

    VDBLIC_INLINE void filterLeaf(std::size_t leaf, std::int32_t* input) const
    {
        const openvdb::Coord origin = domain.origin(leaf);
        const LeafWindow window(domain, origin);
        const LocalContrast::Leaf around(contrast, origin);
        const FullBox inside(domain, window);
        const LeafVelocities displacements(velocities, origin);
        const Domain::Mask& mask = domain.mask(leaf);
        for (int row = 0; row < LeafVoxel::kRows; ++row) {
            const unsigned lanes = mask.getWord<std::uint8_t>(openvdb::Index(row));
            if (lanes == 0) continue;
            const Vector8 way = displacements.row(row);
            const LeafVoxel first = LeafVoxel::ofRow(row);
            Vector8 centre;
            centre.x = broadcast8(float(origin[0] + first.x));
            centre.y = broadcast8(float(origin[1] + first.y));
            centre.z = Float8{0, 1, 2, 3, 4, 5, 6, 7} + float(origin[2]);
            TextureBricks::Samples upstream = texture.at(window, centre - way * 0.5f, lanes);
            if (anyOf(maskOf(lanes) & !(upstream.coverage > 0))) {
                const TextureBricks::Samples here = texture.at(window, centre, lanes);
                const Int8 known = upstream.coverage > 0;
                upstream.texture = known ? upstream.texture : here.texture;
                upstream.sharp = known ? upstream.sharp : here.sharp;
            }

            Int8 value = filtered(around, first, upstream.sharp, input + LeafVoxel::kDim * row);
            const Vector8 before = centre - way;
            if (anyOf(maskOf(lanes) & ~inside.contains(before))) renewEntering(window, centre, before, lanes, value);
            // The texture alone would be smoothed again in each generation, and streaks grow until nothing seems to
            // move.
            const Int8 history = (toFixed(upstream.texture) * 3 + value) >> 2;
            for (int z = 0; z < LeafVoxel::kDim; ++z) {
                if (lanes >> z & 1)
                    input[LeafVoxel::kDim * row + z] = Input::pack(std::uint32_t(value[z]), std::uint32_t(history[z]));
            }
        }
    }

    /// Restore contrast and add noise. @param first voxel of the row  @param input its original noise
    [[nodiscard]] VDBLIC_INLINE Int8 filtered(const LocalContrast::Leaf& around, LeafVoxel first, Float8 sharp,
                                              const std::int32_t* input) const
    {
        Float8 original;
        for (int z = 0; z < LeafVoxel::kDim; ++z)
            original[z] = float(Input::value(input[z])) / kFull;
        if (params.jitter == Jitter::kBits) {
            Float8 jittered;
            for (int z = 0; z < LeafVoxel::kDim; ++z)
                jittered[z] = jitterBits(sharp[z], original[z]);
            return toFixed(jittered);
        }
        // Where there is next to no contrast there is none to restore.
        const LocalContrast::Row local = around.row(first.x, first.y);
        const Float8 least = broadcast8(params.deviation / kMaxGain);
        const Float8 gain = params.deviation / (local.deviation > least ? local.deviation : least);
        const Float8 restored = clampToUnit(0.5f + gain * (sharp - local.mean));
        return toFixed(restored + params.noiseShare * (original - restored));
    }

    /// Where fluid came into the domain during the step, new noise comes with it.
    /// @param before where the fluid in the voxels was at the step's start
    [[gnu::noinline]] void renewEntering(const LeafWindow& window, const Vector8& centre, const Vector8& before,
                                         unsigned lanes, Int8& value) const
    {
        const TextureBricks::Samples there = texture.at(window, before, lanes);
        const Int8 slots = window.slots(floorToInt(before.x), floorToInt(before.y), floorToInt(before.z));
        for (int z = 0; z < LeafVoxel::kDim; ++z) {
            if (!(lanes >> z & 1)) continue;
            // Bricks go on below the domain with its first values; here that is outside.
            const bool inBrick = slots[z] == LeafWindow::kElsewhere ? domain.findLeaf(floorToInt(before.lane(z))) >= 0
                                                                    : window.leaves[std::size_t(slots[z])] >= 0;
            const float stayed = inBrick ? there.coverage[z] : coverageAt(domain, before.lane(z));
            const openvdb::Coord at(int(centre.x[z]), int(centre.y[z]), int(centre.z[z]));
            if (stayed < 1 && noise.fromOutside(at, step, stayed)) value[z] = noise.entering(at, step);
        }
    }
};

VDBLIC_KERNEL void filterLeaf(const FeedForward& filter, std::size_t leaf, std::int32_t* input)
{
    filter.filterLeaf(leaf, input);
}

} // namespace

LeafValues<std::int32_t> feedForward(const VelocityField& field, const LeafValues<float>& texture, const Domain& next,
                                     const NoiseField& noise, const FeedbackParams& params, std::uint64_t step)
{
    const Domain& domain = field.domain();
    const LeafValues<float> sharp = sharpened(domain, texture, params.sharpen);
    TextureBricks bricks(field.sharedDomain(), texture, sharp);
    const LocalContrast contrast(domain, sharp);
    const FeedForward filter{field.end(), domain, bricks, contrast, noise, params, step};

    LeafValues<std::int32_t> input = noiseInput(next, noise);
    const Slabs slabs(domain);
    // Samples lie up to the whole way upstream, and in the cell around that place.
    const int reach = int(std::ceil((std::min(field.largest()[slabs.axis()], 1e6f) + 1) / float(LeafVoxel::kDim)));
    slabs.sweep(
        reach, [&](Slabs::Leaves leaves) { bricks.fill(leaves); },
        [&](Slabs::Leaves leaves) { bricks.release(leaves); },
        [&](Slabs::Leaves leaves) {
            tbb::parallel_for(std::size_t(0), leaves.size(), [&](std::size_t i) {
                const openvdb::Coord origin = domain.origin(leaves[i]);
                const int to = next.findLeaf(Int4{origin[0], origin[1], origin[2], 0});
                if (to >= 0) filterLeaf(filter, leaves[i], input[std::size_t(to)]);
            });
        });
    return input;
}

} // namespace vdblic
