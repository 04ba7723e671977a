#include "vdblic/lic/local_contrast.h"

#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_window.h"

#include <cstddef>

namespace vdblic {

LocalContrast::LocalContrast(const Domain& domain, const LeafValues<float>& values)
    : mDomain(domain), mMoments(domain.leafCount())
{
    forLeaves(domain.local(), [&](std::size_t leaf) {
        Moments& moments = mMoments[leaf];
        moments = {};
        const Domain::Mask& mask = domain.mask(leaf);
        for (int offset = 0; offset < LeafVoxel::kCount; ++offset) {
            if (!mask.isOn(openvdb::Index(offset))) continue;
            const float value = values[leaf][offset];
            moments[std::size_t(blockOf(LeafVoxel::at(unsigned(offset))))] += Float4{1, value, value * value, 0};
        }
    });
}

LocalContrast::Leaf::Leaf(const LocalContrast& contrast, const openvdb::Coord& origin)
{
    const LeafWindow window(contrast.mDomain, origin);
    for (int part = 0; part < kParts; ++part) {
        // Coordinates in voxels from the window's first leaf; part 0 is the last block of that leaf.
        const int x = (part / (kAround * kAround) + 1) * kBlock, y = (part / kAround % kAround + 1) * kBlock,
                  z = (part % kAround + 1) * kBlock;
        const int slot =
            LeafWindow::slot(LeafVoxel::leafCoordinate(x), LeafVoxel::leafCoordinate(y), LeafVoxel::leafCoordinate(z));
        const int leaf = window.leaves[std::size_t(slot)];
        const int block = blockOf({LeafVoxel::local(x), LeafVoxel::local(y), LeafVoxel::local(z)});
        mMoments[std::size_t(part)] = leaf < 0 ? Float4{} : contrast.mMoments[std::size_t(leaf)][std::size_t(block)];
    }
}

} // namespace vdblic
