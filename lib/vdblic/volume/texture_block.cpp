#include "vdblic/volume/texture_block.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

namespace vdblic {
namespace {

/// The rows of a leaf; or of a tile, which are all one.
class SourceRows {
  public:
    /// @param origin of a leaf
    SourceRows(const openvdb::tree::ValueAccessor<const openvdb::FloatTree>& accessor, const openvdb::Coord& origin)
    {
        const openvdb::FloatTree::LeafNodeType* const leaf = accessor.probeConstLeaf(origin);
        if (leaf && leaf->buffer().data()) {
            mValues = leaf->buffer().data();
            mActive = &leaf->getValueMask();
            mStride = LeafVoxel::kDim;
            return;
        }
        float tile = 0;
        if (accessor.probeValue(origin, tile)) mActive = &kAll;
        std::fill_n(mTile, LeafVoxel::kDim, tile);
    }

    [[nodiscard]] VDBLIC_INLINE const float* values(int row) const { return mValues + row * mStride; }
    [[nodiscard]] VDBLIC_INLINE unsigned active(int row) const
    {
        return mActive->getWord<std::uint8_t>(openvdb::Index(row));
    }

  private:
    using Mask = TextureVolume::Mask;
    inline static const Mask kAll{true}, kNone{false};

    float mTile[LeafVoxel::kDim];
    const float* mValues = mTile;
    const Mask* mActive = &kNone;
    std::ptrdiff_t mStride = 0;
};

/// Copy the values of a block from the 27 leaves or tiles that it overlaps.
/// @param active receives the bits of active voxels; may be null
template<int kRim>
VDBLIC_INLINE void copyValues(const openvdb::FloatTree& tree, const openvdb::Coord& origin, float* values,
                              TextureBlock::RowBits* active)
{
    constexpr int kLeafDim = LeafVoxel::kDim, kBegin[] = {-kRim, 0, kLeafDim}, kEnd[] = {0, kLeafDim, kLeafDim + kRim};
    constexpr int kLast = kLeafDim - kRim; // voxels of a row before its last ones
    const openvdb::tree::ValueAccessor<const openvdb::FloatTree> accessor(tree);
    for (int part = 0; part < 9; ++part) {
        const int px = part / 3, py = part % 3;
        const auto rows = [&](int leaf) {
            return SourceRows(accessor, origin.offsetBy((px - 1) * kLeafDim, (py - 1) * kLeafDim, leaf * kLeafDim));
        };
        const SourceRows before = rows(-1), middle = rows(0), after = rows(1);
        for (int x = kBegin[px]; x < kEnd[px]; ++x) {
            for (int y = kBegin[py]; y < kEnd[py]; ++y) {
                const int row = LeafVoxel::row(x, y);
                float* const to = values + TextureBlock::index(x, y, -kRim);
                __builtin_memcpy(to, before.values(row) + kLast, kRim * sizeof(float));
                __builtin_memcpy(to + kRim, middle.values(row), kLeafDim * sizeof(float));
                __builtin_memcpy(to + kRim + kLeafDim, after.values(row), kRim * sizeof(float));
                if (!active) continue;
                const unsigned rim = (1u << kRim) - 1;
                const unsigned bits = before.active(row) >> kLast | middle.active(row) << kRim |
                                      (after.active(row) & rim) << (kRim + kLeafDim);
                active[TextureBlock::row(x, y)] = TextureBlock::RowBits(bits << (TextureBlock::kRim - kRim));
            }
        }
    }
}

/// Half a row of a block.
VDBLIC_INLINE Float8 loadHalf(const float* row, int half)
{
    Float8 values;
    std::memcpy(&values, row + half * std::ptrdiff_t(kLanes), sizeof values);
    return values;
}

/// The lanes of half a row whose bits are set.
VDBLIC_INLINE Int8 halfMask(unsigned bits, int half)
{
    return maskOf(bits >> (half * kLanes) & 0xff);
}

/// The lanes of half a row whose numbers are not finite.
VDBLIC_INLINE Int8 notFinite(const float* row, int half)
{
    constexpr int kExponent = 0x7f800000;
    return (__builtin_bit_cast(Int8, loadHalf(row, half)) & kExponent) == kExponent;
}

/// The least and the largest of numbers.
class Extremes {
  public:
    VDBLIC_INLINE void add(Float8 values, Int8 which)
    {
        const Float8 low = which ? values : broadcast8(kInfinity), high = which ? values : broadcast8(-kInfinity);
        mLow = low < mLow ? low : mLow;
        mHigh = high > mHigh ? high : mHigh;
    }
    [[nodiscard]] VDBLIC_INLINE float low() const
    {
        float least = mLow[0];
        for (int lane = 1; lane < kLanes; ++lane)
            least = std::min(least, mLow[lane]);
        return least;
    }
    [[nodiscard]] VDBLIC_INLINE float high() const
    {
        float most = mHigh[0];
        for (int lane = 1; lane < kLanes; ++lane)
            most = std::max(most, mHigh[lane]);
        return most;
    }

  private:
    static constexpr float kInfinity = std::numeric_limits<float>::infinity();

    Float8 mLow = broadcast8(kInfinity), mHigh = broadcast8(-kInfinity);
};

/// The bits of rows that voxels from −rim to 7 + rim have.
constexpr unsigned bitsWithin(int rim)
{
    return ((1u << (LeafVoxel::kDim + 2 * rim)) - 1) << (TextureBlock::kRim - rim);
}

/// The rows from −rim to 7 + rim along x and y.
template<typename Visit>
VDBLIC_INLINE void forRows(int rim, const Visit& visit)
{
    for (int x = -rim; x < LeafVoxel::kDim + rim; ++x) {
        for (int y = -rim; y < LeafVoxel::kDim + rim; ++y)
            visit(x, y, TextureBlock::row(x, y));
    }
}

} // namespace

void TextureBlock::copyRim(const openvdb::FloatTree& texture, const openvdb::FloatTree* driver,
                           const openvdb::Coord& origin, int rim)
{
    std::fill_n(mActive, kRows, RowBits(0));
    const auto copy = rim == kRim ? copyValues<kRim> : copyValues<TextureLeaf::kRim>;
    copy(texture, origin, mTexture, mActive);
    if (driver) copy(*driver, origin, mDriver, nullptr);
    mHasDriver = driver;
    removeNotFinite(rim);
}

VDBLIC_KERNEL
void TextureBlock::removeNotFinite(int rim)
{
    for (const float* const values : {mTexture, mDriver}) {
        if (values == mDriver && !mHasDriver) continue;
        const auto others = [&](int row, int half) { return notFinite(values + row * std::ptrdiff_t(kDim), half); };
        Int8 any{};
        forRows(rim, [&](int, int, int row) { any |= others(row, 0) | others(row, 1); });
        if (!anyOf(any)) continue;
        forRows(rim, [&](int, int, int row) {
            mActive[row] &= RowBits(~(laneBits(others(row, 0)) | laneBits(others(row, 1)) << kLanes));
        });
    }
    constexpr unsigned kNeeded = bitsWithin(TextureLeaf::kRim);
    mWhole = true;
    forRows(TextureLeaf::kRim, [&](int, int, int row) { mWhole = mWhole && (mActive[row] & kNeeded) == kNeeded; });
}

void TextureBlock::copy(const openvdb::FloatTree& texture, const openvdb::FloatTree* driver,
                        const openvdb::Coord& origin)
{
    mIsSparse = false;
    copyRim(texture, driver, origin, TextureLeaf::kRim);
    if (!mWhole) copyRim(texture, driver, origin, kRim); // extend() needs more
    std::copy_n(mActive, kRows, mKnown);
}

void TextureBlock::copySparse(const openvdb::FloatTree& texture, const openvdb::FloatTree* driver,
                              const openvdb::Coord& origin)
{
    mIsSparse = true;
    copyRim(texture, driver, origin, TextureLeaf::kRim);
    std::copy_n(mActive, kRows, mKnown);
    clearInactive();
}

VDBLIC_KERNEL
void TextureBlock::clearInactive()
{
    forRows(TextureLeaf::kRim, [&](int, int, int row) {
        const unsigned active = mActive[row];
        float* const values = mTexture + row * std::ptrdiff_t(kDim);
        if (active == 0) {
            std::fill_n(values, kDim, 0.0f);
            return;
        }
        for (int half = 0; half < 2; ++half) {
            const Float8 kept = halfMask(active, half) ? loadHalf(values, half) : Float8{};
            std::memcpy(values + half * std::ptrdiff_t(kLanes), &kept, sizeof kept);
        }
    });
}

void TextureBlock::extend()
{
    if (mWhole) return;
    if (mIsSparse) {
        if (mHasDriver) extendBy(ScalarLeaf::kRim);
        return;
    }
    extendBy(kRim - 1);
    extendBy(kRim - 2);
}

VDBLIC_INLINE void TextureBlock::extend(int i, int row, int z)
{
    float texture = 0, driver = 0, count = 0;
    const auto isKnown = [&](int dx, int dy, int dz) {
        const int other = row + dx * kDim + dy;
        return other >= 0 && other < kRows && z + dz >= 0 && (mKnown[other] >> (z + dz) & 1);
    };
    const auto add = [&](int dx, int dy, int dz) {
        if (!isKnown(dx, dy, dz)) return;
        const int step = (dx * kDim + dy) * kDim + dz, j = i + step;
        texture += isKnown(2 * dx, 2 * dy, 2 * dz) ? 2 * mTexture[j] - mTexture[j + step] : mTexture[j];
        driver += mDriver[j];
        count += 1;
    };
    for (const int side : {-1, 1}) {
        add(side, 0, 0);
        add(0, side, 0);
        add(0, 0, side);
    }
    for (int axes = 2; axes <= 3; ++axes) { // along which a neighbour differs
        if (count > 0) break;
        for (int n = 0; n < 27; ++n) {
            const int dx = n / 9 - 1, dy = n / 3 % 3 - 1, dz = n % 3 - 1;
            if ((dx != 0) + (dy != 0) + (dz != 0) == axes) add(dx, dy, dz);
        }
    }
    if (!mIsSparse) mTexture[i] = texture / count;
    mDriver[i] = driver / count;
}

VDBLIC_KERNEL
void TextureBlock::extendBy(int rim)
{
    RowBits known[kRows];
    std::copy_n(mKnown, kRows, known);
    forRows(rim, [&](int, int, int row) {
        const unsigned missing = ~unsigned(mKnown[row]) & bitsWithin(rim);
        if (missing == 0) return;
        unsigned around = 0; // voxels with a neighbour that has a value
        for (const int dx : {-kDim, 0, kDim})
            around |= unsigned(mKnown[row + dx - 1] | mKnown[row + dx] | mKnown[row + dx + 1]);
        around |= around << 1 | around >> 1;
        for (int half = 0; half < 2; ++half) {
            const Int8 isMissing = halfMask(missing, half);
            for (float* const values : {mTexture, mDriver}) {
                if (values == mTexture && mIsSparse) continue;
                float* const at = values + row * std::ptrdiff_t(kDim) + half * std::ptrdiff_t(kLanes);
                const Float8 kept = isMissing ? Float8{} : loadHalf(at, 0);
                std::memcpy(at, &kept, sizeof kept);
            }
        }
        for (unsigned left = missing & around; left != 0; left &= left - 1) {
            const int z = __builtin_ctz(left);
            extend(row * kDim + z, row, z);
            known[row] |= RowBits(1u << z);
        }
    });
    std::copy_n(known, kRows, mKnown);
}

VDBLIC_KERNEL
LeafRange TextureBlock::range() const
{
    Extremes drivers, textures;
    forRows(ScalarLeaf::kRim, [&](int, int, int row) {
        const unsigned active = mActive[row] & bitsWithin(ScalarLeaf::kRim);
        if (active == 0) return;
        for (int half = 0; half < 2; ++half) {
            drivers.add(loadHalf(mDriver + row * std::ptrdiff_t(kDim), half), halfMask(active, half));
            textures.add(loadHalf(mTexture + row * std::ptrdiff_t(kDim), half), halfMask(active, half));
        }
    });
    // Samples lie up to half a voxel past the rim, where textures go on as before it.
    const float beyond = mWhole || mIsSparse ? 0 : (textures.high() - textures.low()) * 0.5f;
    return {drivers.low(), drivers.high(), textures.high() + beyond};
}

VDBLIC_KERNEL
TextureScale TextureBlock::writeTexture(TextureRecord* records) const
{
    static_assert(kDim == 2 * kLanes);
    constexpr int kSkip = kRim - TextureLeaf::kRim;
    const auto known = [&](int row) {
        return (mIsSparse ? ~0u : unsigned(mKnown[row])) & bitsWithin(TextureLeaf::kRim);
    };
    Extremes extremes;
    forRows(TextureLeaf::kRim, [&](int, int, int row) {
        for (int half = 0; half < 2; ++half)
            extremes.add(loadHalf(mTexture + row * std::ptrdiff_t(kDim), half), halfMask(known(row), half));
    });
    const float low = extremes.low(), high = extremes.high();
    const float perUnit = high / TextureScale::kUnits - low / TextureScale::kUnits;
    const float units = perUnit > 0 ? 1 / perUnit : 0;
    forRows(TextureLeaf::kRim, [&](int x, int y, int row) {
        TextureRecord numbers[kDim];
        for (int half = 0; half < 2; ++half) {
            using Short8 = TextureRecord __attribute__((vector_size(16)));
            const Float8 share = (loadHalf(mTexture + row * std::ptrdiff_t(kDim), half) - low) * units + 0.5f;
            const Float8 bounded = share < TextureScale::kUnits ? share : broadcast8(TextureScale::kUnits);
            const Float8 rounded = halfMask(known(row), half) ? bounded : Float8{};
            const auto shorts = __builtin_convertvector(__builtin_convertvector(rounded, Int8), Short8);
            std::memcpy(numbers + half * std::ptrdiff_t(kLanes), &shorts, sizeof shorts);
        }
        std::copy_n(numbers + kSkip, TextureLeaf::kDim, records + TextureLeaf::index(x, y, -TextureLeaf::kRim));
    });
    return {low, perUnit};
}

void TextureBlock::writeDrivers(float* values) const
{
    forRows(ScalarLeaf::kRim, [&](int x, int y, int) {
        std::copy_n(mDriver + index(x, y, -ScalarLeaf::kRim), ScalarLeaf::kDim,
                    values + ScalarLeaf::index(x, y, -ScalarLeaf::kRim));
    });
}

std::size_t TextureBlock::removeInactive(TextureVolume::Mask& mask) const
{
    if (mWhole) return 0;
    std::size_t removed = 0;
    for (int x = 0; x < LeafVoxel::kDim; ++x) {
        auto& word = mask.getWord<openvdb::Index64>(openvdb::Index(x));
        for (int y = 0; y < LeafVoxel::kDim; ++y) {
            const auto active = std::uint64_t(mActive[row(x, y)] >> kRim & 0xff) << (LeafVoxel::kDim * y);
            const std::uint64_t lost = word & (std::uint64_t(0xff) << (LeafVoxel::kDim * y)) & ~active;
            removed += std::size_t(__builtin_popcountll(lost));
            word &= ~lost;
        }
    }
    return removed;
}

} // namespace vdblic
