#include "vdblic/field/slabs.h"

#include "vdblic/field/leaf_voxel.h"

#include <algorithm>
#include <numeric>

namespace vdblic {
namespace {

constexpr std::size_t kEnoughLeaves = 1024; // half a million voxels

} // namespace

Slabs::Slabs(const Domain& domain) : mLeaves(domain.leafCount())
{
    if (mLeaves.empty()) return;
    openvdb::CoordBBox box;
    for (std::size_t leaf = 0; leaf < mLeaves.size(); ++leaf)
        box.expand(domain.origin(leaf));
    mAxis = int(box.maxExtent());
    const auto layerOf = [&](std::uint32_t leaf) { return LeafVoxel::leafCoordinate(domain.origin(leaf)[mAxis]); };
    std::iota(mLeaves.begin(), mLeaves.end(), 0u);
    std::stable_sort(mLeaves.begin(), mLeaves.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return layerOf(a) < layerOf(b); });
    for (std::size_t i = 0; i < mLeaves.size(); ++i) {
        const int layer = layerOf(mLeaves[i]);
        if (i == 0 || (layer != mSlabs.back().last && i - mSlabs.back().begin >= kEnoughLeaves)) {
            mSlabs.push_back({layer, layer, i});
        }
        mSlabs.back().last = layer;
    }
    for (std::size_t slab = 0; slab < mSlabs.size(); ++slab) {
        const Leaves leaves = (*this)[slab];
        const auto begin = mLeaves.begin() + std::ptrdiff_t(mSlabs[slab].begin);
        std::sort(begin, begin + std::ptrdiff_t(leaves.size()));
    }
}

Slabs::Leaves Slabs::operator[](std::size_t slab) const
{
    const std::size_t begin = mSlabs[slab].begin, end = slab + 1 < size() ? mSlabs[slab + 1].begin : mLeaves.size();
    return Leaves(mLeaves).subspan(begin, end - begin);
}

} // namespace vdblic
