#include "vdblic/methods/auflic/sharp_texture.h"

#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/lic/sharpen.h"

#include <cstdint>
#include <optional>
#include <utility>

namespace vdblic {
namespace {

using TextureRecord = BricksOf<2>::Record;

/// Set the records of a leaf's brick to the texture and its coverage.
/// @param values of each leaf
VDBLIC_KERNEL void fillBrick(const Domain& domain, const std::vector<std::unique_ptr<float[]>>& values,
                             const LeafWindow& window, TextureRecord* records)
{
    for (int x = 0; x <= LeafVoxel::kDim; ++x) {
        for (int y = 0; y <= LeafVoxel::kDim; ++y) {
            const int slot = LeafWindow::slot(LeafVoxel::leafCoordinate(x) + 1, LeafVoxel::leafCoordinate(y) + 1, 1);
            const int here = window.leaves[std::size_t(slot)], after = window.leaves[std::size_t(slot) + 1];
            const int row = LeafVoxel::row(x, y);
            const auto bitsOf = [&](int leaf) {
                return leaf < 0 ? 0u : domain.mask(std::size_t(leaf)).getWord<std::uint8_t>(openvdb::Index(row));
            };
            const auto rowOf = [&](int leaf) {
                return values[std::size_t(leaf)].get() + row * std::ptrdiff_t(LeafVoxel::kDim);
            };
            TextureRecord* const to = records + BricksOf<2>::index(x, y, 0);
            const Float8 coverage = maskOf(bitsOf(here)) ? broadcast8(1) : Float8{};
            Float8 texture{};
            if (here >= 0) __builtin_memcpy(&texture, rowOf(here), sizeof texture);
            const Float8 low = __builtin_shufflevector(texture, coverage, 0, 8, 1, 9, 2, 10, 3, 11);
            const Float8 high = __builtin_shufflevector(texture, coverage, 4, 12, 5, 13, 6, 14, 7, 15);
            __builtin_memcpy(to, &low, sizeof low);
            __builtin_memcpy(to + LeafVoxel::kDim / 2, &high, sizeof high);
            to[LeafVoxel::kDim] = (bitsOf(after) & 1) != 0 ? TextureRecord{{*rowOf(after), 1}} : TextureRecord{};
        }
    }
}

} // namespace

SharpTexture::SharpTexture(std::shared_ptr<const Domain> domain, const LeafValues<float>& texture, float strength,
                           const Slabs& slabs)
    : mTexture(texture), mStrength(strength), mSlabs(slabs), mContrast(*domain), mValues(domain->leafCount()),
      mIsSharpened(slabs.size()), mIsFilled(slabs.size())
{
    mBricks.cover(std::move(domain));
}

void SharpTexture::open(std::size_t slab)
{
    // A brick includes the first voxels of the next leaves.
    const std::optional<std::size_t> next = mSlabs.after(slab);
    sharpenSlab(slab);
    if (next) sharpenSlab(*next);
    mBricks.fill(mSlabs[slab], [&](std::size_t leaf, TextureRecord* records) {
        const Domain& domain = mBricks.domain();
        fillBrick(domain, mValues, LeafWindow(domain, domain.origin(leaf)), records);
    });
    mIsFilled[slab] = true;
    releaseValues(slab);
    if (next) releaseValues(*next);
}

/// Free a slab's values, unless bricks to fill need them.
void SharpTexture::releaseValues(std::size_t slab)
{
    if (!mIsFilled[slab] || !mIsFilled[mSlabs.before(slab).value_or(slab)]) return;
    for (const std::uint32_t leaf : mSlabs[slab])
        mValues[leaf].reset();
}

void SharpTexture::sharpenSlab(std::size_t slab)
{
    if (mIsSharpened[slab]) return;
    mIsSharpened[slab] = true;
    forLeaves(mSlabs[slab], [&](std::size_t leaf) {
        mValues[leaf].reset(new float[LeafVoxel::kCount]);
        sharpen(mBricks.domain(), mTexture, leaf, mStrength, {}, mValues[leaf].get());
        mContrast.add(leaf, mValues[leaf].get());
    });
}

} // namespace vdblic
