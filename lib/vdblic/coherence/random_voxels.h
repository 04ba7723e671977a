#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/noise/noise.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

/// Voxels of a frame's domain, chosen by hash, uniformly. Immutable; any number of threads may read.
class RandomVoxels {
  public:
    RandomVoxels(const Domain& domain, std::int64_t frame)
        // The factor keeps frame k + 1 from using the voxels of frame k shifted by one.
        : mDomain(domain), mKey(mixBits(std::uint64_t(frame) * 0x9e3779b97f4a7c15u + 1))
    {
        mVoxelsBefore.reserve(domain.leafCount() + 1);
        for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf)
            mVoxelsBefore.push_back(mVoxelsBefore.back() + domain.mask(leaf).countOn());
    }

    /// Random bits that belong to a number.
    [[nodiscard]] std::uint64_t hash(std::uint64_t number) const { return mixBits(mKey + number); }

    /// The centre of a voxel of the domain, in index space. The domain must have voxels.
    [[nodiscard]] Float4 centre(std::uint64_t hash) const { return centreOf(below(count(), hash)); }

    /// The centre of a voxel of one of equal parts of the domain, in scan order; at most count() parts. Voxels of
    /// different parts differ, and count() parts are all voxels.
    [[nodiscard]] Float4 centreInPart(std::size_t part, std::size_t parts) const
    {
        const std::size_t begin = part * count() / parts, end = (part + 1) * count() / parts;
        return centreOf(begin + below(end - begin, hash(part)));
    }

    [[nodiscard]] std::size_t count() const { return mVoxelsBefore.back(); }

  private:
    /// A number below a limit.
    [[nodiscard]] static std::size_t below(std::size_t limit, std::uint64_t hash)
    {
        return std::size_t((hash >> 32) * limit >> 32);
    }
    [[nodiscard]] Float4 centreOf(std::size_t rank) const
    {
        const auto after = std::upper_bound(mVoxelsBefore.begin(), mVoxelsBefore.end(), rank);
        const auto leaf = std::size_t(after - mVoxelsBefore.begin()) - 1;
        auto voxel = mDomain.mask(leaf).beginOn();
        for (std::size_t skip = rank - mVoxelsBefore[leaf]; skip > 0; --skip)
            ++voxel;
        const openvdb::Coord origin = mDomain.origin(leaf);
        const LeafVoxel inLeaf = LeafVoxel::at(voxel.pos());
        return Float4{float(origin[0] + inLeaf.x), float(origin[1] + inLeaf.y), float(origin[2] + inLeaf.z), 0};
    }

    const Domain& mDomain;
    std::uint64_t mKey;                        // added to a number before hashing
    std::vector<std::size_t> mVoxelsBefore{0}; // each leaf: voxels of the leaves before it; last: all voxels
};

} // namespace vdblic
