#pragma once

#include "vdblic/field/vector.h"
#include "vdblic/volume/texture_records.h"

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace vdblic {

/// Eight numbers as floats.
VDBLIC_INLINE Float8 loadBFloat16s(const BFloat16* values)
{
    return __builtin_bit_cast(Float8, loadShorts(values, values + kLanes / 2) << 16);
}

VDBLIC_INLINE Float8 mix(Float8 from, Float8 to, Float8 share)
{
    return from + (to - from) * share;
}

/// The cells of a lattice that eight positions lie in.
struct Cells {
    Int8 low[3];        ///< lattice points at their lowest corners
    Float8 fraction[3]; ///< positions in the cells, 0 to 1

    Cells() = default;
    /// @param position above −1, along each axis
    VDBLIC_INLINE explicit Cells(const Float8* position)
    {
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = __builtin_convertvector(position[axis] + 1, Int8) - 1;
            fraction[axis] = position[axis] - __builtin_convertvector(low[axis], Float8);
        }
    }
    /// The positions along an axis.
    [[nodiscard]] VDBLIC_INLINE Float8 position(int axis) const
    {
        return __builtin_convertvector(low[axis], Float8) + fraction[axis];
    }
};

/// Two numbers that are neighbours along z, for each of eight lanes.
struct ZPair {
    Float8 first, second;

    [[nodiscard]] VDBLIC_INLINE Float8 mixed(Float8 share) const { return mix(first, second, share); }
    [[nodiscard]] VDBLIC_INLINE Float8 step() const { return second - first; }
};

/// Eight bytes of each lane, parted into halves. @param at where they are, in units of a number
template<typename Half, typename Number>
VDBLIC_INLINE void loadHalves(const Number* numbers, const std::uint32_t (&at)[kLanes], Half& first, Half& second)
{
    const auto four = [&](int a, int b, int c, int d) {
        std::uint64_t words[4];
        const int lanes[] = {a, b, c, d};
        for (int i = 0; i < 4; ++i)
            std::memcpy(&words[i], numbers + at[lanes[i]], sizeof words[i]);
        return __builtin_bit_cast(Half, UnsignedLong4{words[0], words[1], words[2], words[3]});
    };
    // In this order, two shuffles within the halves of a register part them.
    const Half low = four(0, 1, 4, 5), high = four(2, 3, 6, 7);
    first = __builtin_shufflevector(low, high, 0, 2, 8, 10, 4, 6, 12, 14);
    second = __builtin_shufflevector(low, high, 1, 3, 9, 11, 5, 7, 13, 15);
}
/// @param at where the first number of each lane is, in units of its size
VDBLIC_INLINE ZPair loadPair(const float* numbers, const std::uint32_t (&at)[kLanes])
{
    ZPair pair;
    loadHalves(numbers, at, pair.first, pair.second);
    return pair;
}
/// Two records that are neighbours along z, for each of eight lanes; the first one in the lower half of its word.
VDBLIC_INLINE Unsigned8 loadWords(const TextureRecord* records, const std::uint32_t (&at)[kLanes])
{
    Unsigned8 words; // loaded one by one: a gather instruction takes longer (AMD Zen 4)
    for (int lane = 0; lane < kLanes; ++lane) {
        std::uint32_t word;
        std::memcpy(&word, records + at[lane], sizeof word);
        words[lane] = word;
    }
    return words;
}
VDBLIC_INLINE ZPair asPair(Unsigned8 words)
{
    return {__builtin_convertvector(Int8(words & 0xffff), Float8), __builtin_convertvector(Int8(words >> 16), Float8)};
}

/// Weights of the four next points in cubic convolution (Keys, "Cubic convolution interpolation for digital image
/// processing", 1981, with a = −½). @param u from the second to the third point, 0 to 1
VDBLIC_INLINE void cubicWeights(Float8 u, Float8* weights)
{
    const Float8 v = 1 - u;
    weights[0] = -0.5f * u * v * v;
    weights[1] = v * (1 + u - 1.5f * u * u);
    weights[2] = u * (1 + v - 1.5f * v * v);
    weights[3] = -0.5f * v * u * u;
}

/// Bilinear interpolation between numbers at 00, 01, 10 and 11 along x and y.
VDBLIC_INLINE Float8 interpolate(const Float8 (&corners)[4], const Float8* fraction)
{
    return mix(mix(corners[0], corners[1], fraction[1]), mix(corners[2], corners[3], fraction[1]), fraction[0]);
}
/// Trilinear interpolation in eight cells. @param y, x distances of neighbours in memory
VDBLIC_INLINE Float8 interpolate(const float* numbers, Unsigned8 low, int y, int x, const Float8* fraction)
{
    std::uint32_t at[kLanes];
    storeLanes(low, at);
    const auto edge = [&](int offset) { return loadPair(numbers + offset, at).mixed(fraction[2]); };
    return interpolate({edge(0), edge(y), edge(x), edge(x + y)}, fraction);
}

/// The textures at the corners of eight cells.
struct CornerTextures {
    Unsigned8 words[4]; ///< of records at the edges along z, as interpolate() has them
    ZPair scale;        ///< TextureScale

    /// Trilinear. @param fraction positions in the cells
    [[nodiscard]] VDBLIC_INLINE Float8 at(const Float8* fraction) const
    {
        const auto edge = [&](int i) { return asPair(words[i]).mixed(fraction[2]); };
        return scale.first + interpolate({edge(0), edge(1), edge(2), edge(3)}, fraction) * scale.second;
    }
    /// Derivatives of at() along the axes, in index space.
    VDBLIC_INLINE void slopes(const Float8* fraction, Float8* result) const
    {
        const Float8 u = fraction[0], v = fraction[1], w = fraction[2];
        const ZPair edges[] = {asPair(words[0]), asPair(words[1]), asPair(words[2]), asPair(words[3])};
        const Float8 ends[] = {edges[0].mixed(w), edges[1].mixed(w), edges[2].mixed(w), edges[3].mixed(w)};
        const Float8 rises[] = {edges[0].step(), edges[1].step(), edges[2].step(), edges[3].step()};
        result[0] = mix(ends[2] - ends[0], ends[3] - ends[1], v) * scale.second;
        result[1] = mix(ends[1] - ends[0], ends[3] - ends[2], u) * scale.second;
        result[2] = interpolate(rises, fraction) * scale.second;
    }
};

/// The textures of a volume at eight samples at once. Does not own the records.
class TextureSampler {
  public:
    TextureSampler(const TextureRecord* records, const TextureScale* scales) : mRecords(records), mScales(scales) {}

    /// @param leaf numbers of the leaves  @param cells relative to their origins
    [[nodiscard]] VDBLIC_INLINE CornerTextures corners(Unsigned8 leaf, const Cells& cells) const
    {
        std::uint32_t at[kLanes];
        storeLanes(first(leaf, cells), at);
        const auto words = [&](int offset) { return loadWords(mRecords + offset, at); };
        constexpr int kY = TextureLeaf::kY, kX = TextureLeaf::kX;
        return {{words(0), words(kY), words(kX), words(kX + kY)}, scales(leaf)};
    }
    /// Trilinear. @param leaf, cells as of corners()
    [[nodiscard]] VDBLIC_INLINE Float8 at(Unsigned8 leaf, const Cells& cells) const
    {
        return corners(leaf, cells).at(cells.fraction);
    }

    /// By cubic convolution, within the range of the leaf's records. @param leaf, cells as of corners()
    /// @param which the lanes that matter, by their bits
    [[nodiscard]] VDBLIC_INLINE Float8 cubicAt(Unsigned8 leaf, const Cells& cells, unsigned which = 0xff) const
    {
        constexpr int kTaps = 4;
        constexpr std::ptrdiff_t kY = TextureLeaf::kY, kX = TextureLeaf::kX;
        Float8 alongX[kTaps], alongY[kTaps], alongZ[kTaps];
        cubicWeights(cells.fraction[0], alongX);
        cubicWeights(cells.fraction[1], alongY);
        cubicWeights(cells.fraction[2], alongZ);
        float xs[kTaps][kLanes], ys[kTaps][kLanes];
        std::memcpy(xs, alongX, sizeof xs);
        std::memcpy(ys, alongY, sizeof ys);
        std::uint32_t at[kLanes];
        storeLanes(first(leaf, cells) - unsigned(kX + kY + 1), at);
        Float4 rows[kLanes]{}; // four numbers along z, by lane
        for (unsigned left = which; left != 0; left &= left - 1) {
            const int lane = __builtin_ctz(left);
            const auto twice = [&](int y) {
                return __builtin_shufflevector(broadcast4(ys[y][lane]), broadcast4(ys[y + 1][lane]), 0, 1, 2, 3, 4, 5,
                                               6, 7);
            };
            const Float8 before = twice(0), after = twice(2);
            const TextureRecord* records = mRecords + at[lane];
            const auto fours = [&](int y) {
                return __builtin_convertvector(loadShorts(records + y * kY, records + (y + 1) * kY), Float8);
            };
            Float8 sum{};
            for (int x = 0; x < kTaps; ++x, records += kX) {
                const Float8 plane = fours(0) * before + fours(2) * after;
                sum += plane * xs[x][lane];
            }
            rows[lane] = __builtin_shufflevector(sum, sum, 0, 1, 2, 3) + __builtin_shufflevector(sum, sum, 4, 5, 6, 7);
        }
        Float8 columns[kTaps];
        transpose(rows, columns);
        Float8 share{};
        for (int z = 0; z < kTaps; ++z)
            share += columns[z] * alongZ[z];
        share = share > 0 ? share : Float8{};
        share = share < TextureScale::kUnits ? share : broadcast8(TextureScale::kUnits);
        const ZPair scale = scales(leaf);
        return scale.first + share * scale.second;
    }

    /// Central differences at the cells' corners, interpolated: gradients that do not jump, in index space.
    VDBLIC_INLINE void gradients(Unsigned8 leaf, const Cells& cells, Float8* result) const
    {
        constexpr int kY = TextureLeaf::kY, kX = TextureLeaf::kX;
        std::uint32_t at[kLanes];
        storeLanes(first(leaf, cells), at);
        const Float8 u = cells.fraction[0], v = cells.fraction[1], w = cells.fraction[2];
        const auto end = [&](int offset) { return asPair(loadWords(mRecords + offset, at)).mixed(w); };
        Float8 inner[4], along[4]; // values and twice their derivatives along z, at the four corners across
        for (int i = 0; i < 4; ++i) {
            const int offset = (i >> 1) * kX + (i & 1) * kY;
            Unsigned8 words[2];
            loadHalves(mRecords + offset - 1, at, words[0], words[1]);
            const ZPair before = asPair(words[0]), after = asPair(words[1]);
            inner[i] = mix(before.second, after.first, w);
            along[i] = mix(after.first - before.first, after.second - before.second, w);
        }
        const Float8 half = scales(leaf).second * 0.5f;
        result[0] = half * mix(mix(inner[2] - end(-kX), end(2 * kX) - inner[0], u),
                               mix(inner[3] - end(kY - kX), end(2 * kX + kY) - inner[1], u), v);
        result[1] = half * mix(mix(inner[1] - end(-kY), end(2 * kY) - inner[0], v),
                               mix(inner[3] - end(kX - kY), end(kX + 2 * kY) - inner[2], v), u);
        result[2] = half * mix(mix(along[0], along[1], v), mix(along[2], along[3], v), u);
    }

  private:
    /// Where the records at the cells' lowest corners are.
    VDBLIC_INLINE static Unsigned8 first(Unsigned8 leaf, const Cells& cells)
    {
        return leaf * TextureLeaf::kSize + Unsigned8(TextureLeaf::index(cells.low[0], cells.low[1], cells.low[2]));
    }
    VDBLIC_INLINE ZPair scales(Unsigned8 leaf) const
    {
        std::uint32_t at[kLanes];
        storeLanes(leaf * 2, at);
        return loadPair(&mScales->low, at);
    }

    const TextureRecord* mRecords;
    const TextureScale* mScales;
};

/// Trilinear interpolation of the line projectors in one cell.
/// @param corner at the cell's lowest corner  @param x, y, z position in the cell, 0 to 1
VDBLIC_INLINE Float8 sampleLine(const LineRecord* corner, float x, float y, float z)
{
    constexpr int kY = ScalarLeaf::kY, kX = ScalarLeaf::kX;
    const auto pair = [&](int i) {
        return mix(loadBFloat16s(corner[i].values), loadBFloat16s(corner[i + 1].values), broadcast8(z));
    };
    return mix(mix(pair(0), pair(kY), broadcast8(y)), mix(pair(kX), pair(kX + kY), broadcast8(y)), broadcast8(x));
}

} // namespace vdblic
