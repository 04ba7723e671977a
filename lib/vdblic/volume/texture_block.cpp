#include "vdblic/volume/texture_block.h"

#include "vdblic/volume/coarse_scalar.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace vdblic {
namespace {

/// Copy the rows of a block that lie in one leaf or tile: those from `begin` to `end` along x and y, and as many voxels
/// along z as a block has of that leaf.
/// @param leaf   or null: then all voxels are as the tile
/// @param active receives 1 for active voxels, else 0; may be null
template<int kCount>
VDBLIC_INLINE void copyRows(const openvdb::FloatTree::LeafNodeType* leaf, float tile, bool tileActive,
                            const openvdb::Coord& begin, int endX, int endY, float* values, int* active)
{
    const float* source = leaf ? leaf->buffer().data() : nullptr;
    for (int x = begin[0]; x < endX; ++x) {
        for (int y = begin[1]; y < endY; ++y) {
            const int i = TextureBlock::index(x, y, begin[2]);
            const auto offset = unsigned(LeafVoxel::offset(x, y, begin[2]));
            if (source) {
                std::copy_n(source + offset, kCount, values + i);
            } else {
                std::fill_n(values + i, kCount, tile);
            }
            if (!active) continue;
            unsigned bits = tileActive ? ~0u : 0;
            if (leaf) bits = unsigned(leaf->getValueMask().getWord<openvdb::Index64>(offset >> 6) >> (offset & 63));
            for (int z = 0; z < kCount; ++z)
                active[i + z] = int(bits >> z & 1);
        }
    }
}

/// Copy the values of a block from the 27 leaves or tiles that it overlaps.
/// @param active receives 1 for active voxels, else 0; may be null
VDBLIC_INLINE void copyValues(const openvdb::FloatTree& tree, const openvdb::Coord& origin, float* values, int* active)
{
    constexpr int kLeafDim = LeafVoxel::kDim, kBegin[] = {-2, 0, kLeafDim}, kEnd[] = {0, kLeafDim, kLeafDim + 2};
    const openvdb::tree::ValueAccessor<const openvdb::FloatTree> accessor(tree);
    for (int part = 0; part < 27; ++part) {
        const int p[] = {part / 9, part / 3 % 3, part % 3};
        const openvdb::Coord begin(kBegin[p[0]], kBegin[p[1]], kBegin[p[2]]);
        const openvdb::FloatTree::LeafNodeType* leaf = accessor.probeConstLeaf(origin + begin);
        float tile = 0;
        const bool tileActive = !leaf && accessor.probeValue(origin + begin, tile);
        const auto copy = p[2] == 1 ? copyRows<kLeafDim> : copyRows<2>;
        copy(leaf, tile, tileActive, begin, kEnd[p[0]], kEnd[p[1]], values, active);
    }
}

/// 1 for a finite number, else 0. Tests the exponent, so that loops vectorize.
int isFinite(float x)
{
    constexpr std::uint32_t kExponent = 0x7f800000;
    return (__builtin_bit_cast(std::uint32_t, x) & kExponent) != kExponent;
}

/// The derivative along one axis from the active neighbours [texture/voxel]; 0 where the voxel itself is inactive.
float difference(const float* value, const int* active, int stride)
{
    const bool before = active[-stride], after = active[stride];
    if (!*active) return 0;
    if (before && after) return (value[stride] - value[-stride]) * 0.5f;
    if (after) return value[stride] - *value;
    return before ? *value - value[-stride] : 0.0f;
}

} // namespace

void TextureBlock::copy(const openvdb::FloatTree& texture, const openvdb::FloatTree& driver,
                        const openvdb::Coord& origin)
{
    copyValues(texture, origin, mTexture, mActive);
    copyValues(driver, origin, mDriver, nullptr);
    copied();
    mHasDrivers = false;
}

void TextureBlock::copy(const openvdb::FloatTree& texture, const CoarseScalar& driver, const openvdb::Coord& origin)
{
    static_assert(kDim <= CoarseScalar::kMostDim);
    copyValues(texture, origin, mTexture, mActive);
    driver.sample(origin.offsetBy(-2, -2, -2), kDim, mDriver);
    copied();
    mHasDrivers = true;
    for (float& value : mDriver)
        value = isFinite(value) ? value : 0;
}

/// The voxels that are active in texture and driver.
void TextureBlock::copied()
{
    int active = 0;
    for (int i = 0; i < kSize; ++i) {
        mActive[i] &= isFinite(mTexture[i]) & isFinite(mDriver[i]);
        active += mActive[i];
    }
    mWhole = active == kSize;
    mIsEmpty = false;
}

void TextureBlock::setEmpty()
{
    for (int i = 0; i < kSize; ++i)
        mTexture[i] = mActive[i] ? mTexture[i] : 0;
    mIsEmpty = true;
}

void TextureBlock::extend()
{
    if (mWhole || (mIsEmpty && mHasDrivers)) return;
    unsigned rows[kDim * kDim] = {}; // a bit for each active voxel of a row along z
    for (int row = 0; row < kDim * kDim; ++row) {
        for (int z = 0; z < kDim; ++z)
            rows[row] |= unsigned(mActive[row * kDim + z]) << z;
    }
    for (int x = -1; x <= LeafVoxel::kDim; ++x) {
        for (int y = -1; y <= LeafVoxel::kDim; ++y) {
            const int row = index(x, y, -2) / kDim;
            unsigned around = 0; // voxels with an active neighbour
            for (const int dx : {-kDim, 0, kDim})
                around |= rows[row + dx - 1] | rows[row + dx] | rows[row + dx + 1];
            around |= around << 1 | around >> 1;
            for (int z = 1; z <= kPaddedDim; ++z) {
                if (rows[row] >> z & 1) continue;
                const int i = row * kDim + z;
                mTexture[i] = 0;
                mDriver[i] = 0;
                if (around >> z & 1) extend(i);
            }
        }
    }
}

void TextureBlock::extend(int i)
{
    float texture[4] = {}, driver[4] = {}, count[4] = {}; // by the number of axes along which a neighbour differs
    for (int n = 0; n < 27; ++n) {
        const int dx = n / 9 - 1, dy = n / 3 % 3 - 1, dz = n % 3 - 1;
        const int j = i + (dx * kDim + dy) * kDim + dz;
        if (!mActive[j]) continue;
        const int distance = (dx != 0) + (dy != 0) + (dz != 0);
        texture[distance] += mTexture[j];
        driver[distance] += mDriver[j];
        count[distance] += 1;
    }
    int nearest = 1;
    while (count[nearest] == 0)
        ++nearest;
    if (!mIsEmpty) mTexture[i] = texture[nearest] / count[nearest];
    mDriver[i] = driver[nearest] / count[nearest];
}

LeafRange TextureBlock::range() const
{
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    LeafRange range{kInfinity, -kInfinity, -kInfinity};
    for (int x = -1; x <= LeafVoxel::kDim; ++x) {
        for (int y = -1; y <= LeafVoxel::kDim; ++y) {
            for (int z = -1; z <= LeafVoxel::kDim; ++z) {
                const int i = index(x, y, z);
                if (!mActive[i]) continue;
                range.lowDriver = std::min(range.lowDriver, mDriver[i]);
                range.highDriver = std::max(range.highDriver, mDriver[i]);
                range.highTexture = std::max(range.highTexture, mTexture[i]);
            }
        }
    }
    return range;
}

void TextureBlock::writeValues(ValueRecord* records) const
{
    for (int x = -1; x <= LeafVoxel::kDim; ++x) {
        for (int y = -1; y <= LeafVoxel::kDim; ++y) {
            const int i = index(x, y, -1);
            ValueRecord* row = records + paddedIndex(x, y, -1);
            for (int z = 0; z < kPaddedDim; ++z)
                row[z] = {mTexture[i + z], mDriver[i + z]};
        }
    }
}

void TextureBlock::writeDrivers(float* drivers) const
{
    for (int x = -1; x <= LeafVoxel::kDim; ++x) {
        for (int y = -1; y <= LeafVoxel::kDim; ++y)
            std::copy_n(mDriver + index(x, y, -1), kPaddedDim, drivers + paddedIndex(x, y, -1));
    }
}

VDBLIC_KERNEL
void TextureBlock::writeGradients(const glm::mat3& gradientToWorld, GradientRecord* records) const
{
    constexpr int kStrides[] = {kDim * kDim, kDim, 1};
    for (int x = -1; x <= LeafVoxel::kDim; ++x) {
        for (int y = -1; y <= LeafVoxel::kDim; ++y) {
            const float* value = mTexture + index(x, y, -1);
            const int* active = mActive + index(x, y, -1);
            float gradient[3][kPaddedDim];
            for (int axis = 0; axis < 3; ++axis) {
                const int stride = kStrides[axis];
                for (int z = 0; z < kPaddedDim; ++z) {
                    gradient[axis][z] = mWhole || mIsEmpty ? (value[z + stride] - value[z - stride]) * 0.5f
                                                           : difference(value + z, active + z, stride);
                }
            }
            std::uint32_t world[3][kPaddedDim];
            for (int axis = 0; axis < 3; ++axis) {
                for (int z = 0; z < kPaddedDim; ++z) {
                    world[axis][z] = toBFloat16(gradientToWorld[0][axis] * gradient[0][z] +
                                                gradientToWorld[1][axis] * gradient[1][z] +
                                                gradientToWorld[2][axis] * gradient[2][z]);
                }
            }
            GradientRecord* row = records + paddedIndex(x, y, -1);
            for (int z = 0; z < kPaddedDim; ++z)
                row[z] = {{BFloat16(world[0][z]), BFloat16(world[1][z]), BFloat16(world[2][z]), 0}};
        }
    }
}

std::size_t TextureBlock::removeInactive(TextureVolume::Mask& mask) const
{
    if (mWhole) return 0;
    std::size_t removed = 0;
    for (auto i = mask.beginOn(); i; ++i) {
        const LeafVoxel voxel = LeafVoxel::at(i.pos());
        if (mActive[index(voxel.x, voxel.y, voxel.z)]) continue;
        mask.setOff(i.pos());
        ++removed;
    }
    return removed;
}

} // namespace vdblic
