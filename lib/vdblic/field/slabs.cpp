#include "vdblic/field/slabs.h"

#include "vdblic/core/threads.h"
#include "vdblic/field/leaf_voxel.h"

#include <algorithm>

namespace vdblic {

std::size_t Slabs::fewestLeaves()
{
    // A few megabytes of bricks, of a slab and its neighbours, stay in the caches.
    constexpr std::size_t kAlone = 96;
    // Threads keep a distance from one another, so each needs more leaves in a slab.
    constexpr std::size_t kForThread = 512;
    const std::size_t threads = threadCount();
    return threads == 1 ? kAlone : kForThread * threads;
}

Slabs::Slabs(const Domain& domain, const Refinement& refinement)
{
    if (domain.local().empty()) return;
    openvdb::CoordBBox box;
    for (const std::uint32_t leaf : domain.local())
        box.expand(domain.origin(leaf));
    mAxis = int(box.maxExtent());
    mPeriod = LeafVoxel::leafCoordinate(domain.period().size[mAxis]);
    const std::size_t enough = fewestLeaves();
    sortLeaves(domain);
    for (std::size_t i = 0; i < mLeaves.size(); ++i) {
        const openvdb::Coord origin = domain.origin(mLeaves[i]);
        const int layer = LeafVoxel::leafCoordinate(origin[mAxis]);
        const bool mayEnd =
            i > 0 && refinement.coarseLeaf(layer, mAxis) != refinement.coarseLeaf(mSlabs.back().last, mAxis);
        if (i == 0 || (mayEnd && i - mSlabs.back().begin >= enough)) mSlabs.push_back({layer, layer, i});
        mSlabs.back().last = layer;
    }
    sortSlabs();
}

Slabs::Slabs(const Slabs& refined, const Domain& velocity, const Refinement& refinement) : mAxis(refined.mAxis)
{
    sortLeaves(velocity);
    std::size_t leaf = 0;
    for (const Slab& slab : refined.mSlabs) {
        const int first = refinement.coarseLeaf(slab.first, mAxis), last = refinement.coarseLeaf(slab.last, mAxis);
        mSlabs.push_back({first, last, leaf});
        while (leaf < mLeaves.size() && LeafVoxel::leafCoordinate(velocity.origin(mLeaves[leaf])[mAxis]) <= last)
            ++leaf;
    }
    sortSlabs();
}

std::pair<std::size_t, std::size_t> Slabs::awayFromSeam(int reach) const
{
    std::size_t begin = 0, end = size();
    if (mPeriod == 0) return {begin, end};
    const auto isNear = [&](const Slab& late, const Slab& early) { return early.first + mPeriod - late.last <= reach; };
    while (begin < size() && isNear(mSlabs.back(), mSlabs[begin]))
        ++begin;
    while (end > 0 && isNear(mSlabs[end - 1], mSlabs.front()))
        --end;
    return {begin, end};
}

/// Sort by layer, then by number.
void Slabs::sortLeaves(const Domain& domain)
{
    const auto layerOf = [&](std::uint32_t leaf) { return domain.origin(leaf)[mAxis]; };
    mLeaves.assign(domain.local().begin(), domain.local().end());
    std::stable_sort(mLeaves.begin(), mLeaves.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return layerOf(a) < layerOf(b); });
}

void Slabs::sortSlabs()
{
    for (std::size_t slab = 0; slab < mSlabs.size(); ++slab) {
        const auto begin = mLeaves.begin() + std::ptrdiff_t(mSlabs[slab].begin);
        std::sort(begin, begin + std::ptrdiff_t((*this)[slab].size()));
    }
}

Slabs::Leaves Slabs::operator[](std::size_t slab) const
{
    const std::size_t begin = mSlabs[slab].begin, end = slab + 1 < size() ? mSlabs[slab + 1].begin : mLeaves.size();
    return Leaves(mLeaves).subspan(begin, end - begin);
}

} // namespace vdblic
