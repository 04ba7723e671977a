#include "vdblic/lic/texture_bricks.h"

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/leaf_window.h"

#include <cstdint>
#include <utility>

namespace vdblic {
namespace {

using TextureRecord = BricksOf<2>::Record;

/// Set the records of a leaf's brick to the texture and its coverage.
VDBLIC_KERNEL void fillBrick(const Domain& domain, const LeafValues<float>& texture, const LeafWindow& window,
                             TextureRecord* records)
{
    constexpr int kDim = LeafVoxel::kDim;
    for (int x = 0; x <= kDim; ++x) {
        for (int y = 0; y <= kDim; ++y) {
            const int slot = LeafWindow::slot(LeafVoxel::leafCoordinate(x) + 1, LeafVoxel::leafCoordinate(y) + 1, 1);
            const int here = window.leaves[std::size_t(slot)], after = window.leaves[std::size_t(slot) + 1];
            const int row = LeafVoxel::row(x, y);
            const auto bitsOf = [&](int leaf) {
                return leaf < 0 ? 0u : domain.mask(std::size_t(leaf)).getWord<std::uint8_t>(openvdb::Index(row));
            };
            const auto valuesOf = [&](int leaf) { return texture[std::size_t(leaf)] + row * std::ptrdiff_t(kDim); };
            TextureRecord* const to = records + BricksOf<2>::index(x, y, 0);
            const Float8 coverage = maskOf(bitsOf(here)) ? broadcast8(1) : Float8{};
            Float8 values{};
            if (here >= 0) __builtin_memcpy(&values, valuesOf(here), sizeof values);
            const Float8 low = __builtin_shufflevector(values, coverage, 0, 8, 1, 9, 2, 10, 3, 11);
            const Float8 high = __builtin_shufflevector(values, coverage, 4, 12, 5, 13, 6, 14, 7, 15);
            __builtin_memcpy(to, &low, sizeof low);
            __builtin_memcpy(to + kDim / 2, &high, sizeof high);
            to[kDim] = (bitsOf(after) & 1) != 0 ? TextureRecord{{*valuesOf(after), 1}} : TextureRecord{};
        }
    }
}

} // namespace

TextureBricks::TextureBricks(std::shared_ptr<const Domain> domain, const LeafValues<float>& texture) : mTexture(texture)
{
    mBricks.cover(std::move(domain));
}

void TextureBricks::fill(Slabs::Leaves leaves)
{
    mBricks.fill(leaves, [&](std::size_t leaf, TextureRecord* records) {
        const Domain& domain = mBricks.domain();
        fillBrick(domain, mTexture, LeafWindow(domain, domain.origin(leaf)), records);
    });
}

} // namespace vdblic
