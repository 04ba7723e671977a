#include "vdblic/field/domain.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"

#include <fmt/format.h>
#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace vdblic {
namespace {

// A 4 MB table of blocks: 20,000³ voxels in a cube, or a sheet of 250,000 by 250,000.
constexpr std::size_t kMaxBlocks = std::size_t(1) << 22;

// Positions are single precision: up to this coordinate a voxel is resolved to 1/64.
constexpr int kMaxCoordinate = 1 << 17;

} // namespace

Domain::Domain(openvdb::MaskTree::Ptr topology, int ranks, const Period& period)
    : mTopology(std::move(topology)), mPeriod(period), mIsPeriodic(!period.isNone())
{
    checkVoxels(mTopology->activeVoxelCount(), "", ranks, mTopology->activeLeafVoxelCount());
    mTopology->voxelizeActiveTiles();
    // Leaves without an active voxel need no computation; nodes without a leaf would be in every output.
    openvdb::tools::pruneInactive(*mTopology);
    mTopology->getNodes(mLeaves);
    mOwn.resize(mLeaves.size());
    std::iota(mOwn.begin(), mOwn.end(), 0u);
    mLocal = mOwn;
    if (mLeaves.empty()) return;

    openvdb::CoordBBox box;
    mBoxes.reserve(mLeaves.size());
    for (const Leaf* leaf : mLeaves) {
        mBoxes.emplace_back(leaf->getValueMask());
        box.expand(leaf->origin());
        mVoxelCount += leaf->onVoxelCount();
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (box.min()[axis] < -kMaxCoordinate || box.max()[axis] >= kMaxCoordinate) {
            throw InputError(
                fmt::format("active voxels reach from {} to {} along axis {}; indices beyond ±{} cannot be "
                            "traced accurately: move the grid's origin or cut it with `box`",
                            box.min()[axis], box.max()[axis] + LeafVoxel::kDim - 1, axis, kMaxCoordinate));
        }
        mFirstBlock[axis] = box.min()[axis] >> LeafBlock::kLog2Voxels;
        mBlockDim[axis] = unsigned((box.max()[axis] >> LeafBlock::kLog2Voxels) - mFirstBlock[axis] + 1);
    }
    const std::size_t blocks = std::size_t(mBlockDim[0]) * mBlockDim[1] * mBlockDim[2];
    if (blocks > kMaxBlocks) {
        throw InputError(fmt::format("active voxels spread over {}x{}x{} blocks of 128 voxels; at most {} blocks are "
                                     "supported: cut the domain with `box`",
                                     mBlockDim[0], mBlockDim[1], mBlockDim[2], kMaxBlocks));
    }

    mBlocks.assign(blocks, -1);
    placeLeaves();
}

std::shared_ptr<const Domain> Domain::ofRank(std::vector<std::uint32_t> own, std::vector<std::uint32_t> local) const
{
    auto domain = std::make_shared<Domain>(*this);
    domain->mOwn = std::move(own);
    domain->mLocal = std::move(local);
    domain->mIsOwn.assign(mLeaves.size(), 0);
    for (const std::uint32_t leaf : domain->mOwn)
        domain->mIsOwn[leaf] = 1;
    domain->placeLeaves();
    return domain;
}

std::uint64_t Domain::firstVoxelNumber(std::size_t leaf) const
{
    const openvdb::Coord c = mLeaves[leaf]->origin();
    const int leafIndex = LeafBlock::leafIndex(c[0], c[1], c[2]);
    return (std::uint64_t(blockIndex(c)) * LeafBlock::kCount + std::uint64_t(leafIndex)) * kLeafVoxels;
}

/// findLeaf() of a voxel outside a periodic box.
int Domain::leafOfImage(const openvdb::Coord& voxel) const
{
    return leafAt(mPeriod.wrapped(voxel));
}

std::size_t Domain::blockIndex(const openvdb::Coord& voxel) const
{
    const auto along = [&](int axis) {
        return std::size_t((voxel[axis] >> LeafBlock::kLog2Voxels) - mFirstBlock[axis]);
    };
    return (along(0) * mBlockDim[1] + along(1)) * mBlockDim[2] + along(2);
}

/// Enter the local leaves into the tables.
void Domain::placeLeaves()
{
    std::fill(mBlocks.begin(), mBlocks.end(), -1);
    mLeafOfBlock.clear();
    for (const std::uint32_t leaf : mLocal) {
        const openvdb::Coord c = mLeaves[leaf]->origin();
        int& block = mBlocks[blockIndex(c)];
        if (block < 0) {
            block = int(mLeafOfBlock.size() / LeafBlock::kCount);
            mLeafOfBlock.resize(mLeafOfBlock.size() + LeafBlock::kCount, -1);
        }
        const int leafIndex = LeafBlock::leafIndex(c[0], c[1], c[2]);
        mLeafOfBlock[std::size_t(block) * LeafBlock::kCount + std::size_t(leafIndex)] = int(leaf);
    }
}

} // namespace vdblic
