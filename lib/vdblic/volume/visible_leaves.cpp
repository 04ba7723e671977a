#include "vdblic/volume/visible_leaves.h"

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/texture_volume.h"

namespace vdblic {
namespace {

std::vector<std::uint8_t> findVisible(const TextureVolume& volume, const Look& look)
{
    std::vector<std::uint8_t> visible(volume.leafCount());
    for (std::size_t leaf = 0; leaf < visible.size(); ++leaf)
        visible[leaf] = !volume.shown(leaf).isOff() && look.contributes(volume.leafRange(leaf));
    return visible;
}

} // namespace

VisibleLeaves::VisibleLeaves(const TextureVolume& volume, const std::vector<std::uint8_t>& visible)
    : mLeaves(LeafBlock::kCount, kNothing)
{
    const Domain& domain = volume.domain();
    openvdb::CoordBBox box;
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf)
        box.expand(domain.origin(leaf));
    if (box.empty()) return;
    mOrigin = box.min().offsetBy(-LeafVoxel::kDim);
    for (int axis = 0; axis < 3; ++axis)
        mDim[axis] = (box.max()[axis] - mOrigin[axis]) / kBlockDim + 1;
    mBlocks.assign(std::size_t(mDim[0]) * mDim[1] * mDim[2], kNoBlock);
    for (std::size_t leaf = 0; leaf < visible.size(); ++leaf) {
        if (!visible[leaf]) continue;
        const openvdb::Coord voxel = volume.origin(leaf) - mOrigin;
        int& block = mBlocks[blockIndex(voxel[0] / kBlockDim, voxel[1] / kBlockDim, voxel[2] / kBlockDim)];
        if (block == kNoBlock) {
            block = int(mLeaves.size());
            mLeaves.resize(mLeaves.size() + LeafBlock::kCount, kNothing);
        }
        const unsigned base =
            unsigned(leaf * kPaddedSize) - recordOffset(unsigned(voxel[0]), unsigned(voxel[1]), unsigned(voxel[2]));
        mLeaves[std::size_t(block) + std::size_t(LeafBlock::leafIndex(voxel[0], voxel[1], voxel[2]))] =
            base | (volume.shown(leaf).isOn() ? 0 : kPartly);
    }
}

VisibleLeaves::VisibleLeaves(const TextureVolume& volume, const Look& look)
    : VisibleLeaves(volume, findVisible(volume, look))
{
}

} // namespace vdblic
