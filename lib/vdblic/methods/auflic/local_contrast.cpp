#include "vdblic/methods/auflic/local_contrast.h"

#include "vdblic/field/domain_rows.h"
#include "vdblic/field/leaf_window.h"

#include <cstddef>

namespace vdblic {

/// Sums add a block's voxels in the order of their offsets; blocks lie side by side in lanes.
VDBLIC_KERNEL void LocalContrast::sumBlocks(const Domain::Mask& mask, const float* values, Moments& moments)
{
    Float8 sums[4] = {}; // of count, value and square
    for (int x = 0; x < kBlock; ++x) {
        for (int y = 0; y < kBlock; ++y) {
            Float8 ones[4], numbers[4]; // the rows of the four blocks at z = 0, each beside the next block's
            for (int block = 0; block < 4; ++block) {
                const int row = LeafVoxel::row(x + block / kBlocks * kBlock, y + block % kBlocks * kBlock);
                const Int8 on = activeRow(mask, row);
                ones[block] = on ? broadcast8(1) : Float8{};
                numbers[block] = on ? loadRow(values, row) : Float8{};
            }
            transposePairs(ones, ones);
            transposePairs(numbers, numbers);
            for (int z = 0; z < kBlock; ++z) {
                sums[0] += ones[z];
                sums[1] += numbers[z];
                sums[2] += numbers[z] * numbers[z];
            }
        }
    }
    for (int block = 0; block < kBlockCount; ++block) {
        const int lane = block / kBlocks + block % kBlocks * 4;
        moments[std::size_t(block)] = Float4{sums[0][lane], sums[1][lane], sums[2][lane], 0};
    }
}

LocalContrast::LocalContrast(const Domain& domain) : mDomain(domain), mMoments(domain.leafCount()) {}

LocalContrast::Leaf::Leaf(const LocalContrast& contrast, const openvdb::Coord& origin)
{
    const LeafWindow window(contrast.mDomain, origin);
    for (int part = 0; part < kParts; ++part) {
        // Coordinates are voxels from the window's first leaf; part 0 is the last block of that leaf.
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
