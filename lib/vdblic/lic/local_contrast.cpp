#include "vdblic/lic/local_contrast.h"

#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_window.h"

#include <cstddef>

namespace vdblic {
namespace {

/// The two neighbouring blocks whose centres enclose a voxel along one axis.
struct Enclosing {
    int first;    ///< counted from the block before the leaf
    float weight; ///< of the second block
};
constexpr Enclosing enclosing(int voxel)
{
    const int first = (voxel + 2) / 4;
    return {first, (float(voxel) + 2.5f) / 4 - float(first)};
}

} // namespace

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

LocalContrast::Row LocalContrast::Leaf::row(int x, int y) const
{
    const Enclosing inX = enclosing(x), inY = enclosing(y);
    std::array<Float4, kAround> along; // the moments at this x and y, of each block along z
    for (int k = 0; k < kAround; ++k) {
        const auto at = [&](int i, int j) {
            const int part = ((inX.first + i) * kAround + inY.first + j) * kAround + k;
            return mMoments[std::size_t(part)];
        };
        const auto mix = [](Float4 a, Float4 b, float t) { return a + (b - a) * t; };
        along[std::size_t(k)] =
            mix(mix(at(0, 0), at(0, 1), inY.weight), mix(at(1, 0), at(1, 1), inY.weight), inX.weight);
    }
    Float8 count, sum, squares;
    for (int z = 0; z < LeafVoxel::kDim; ++z) {
        const Enclosing inZ = enclosing(z);
        const Float4 a = along[std::size_t(inZ.first)], b = along[std::size_t(inZ.first) + 1];
        const Float4 moments = a + (b - a) * inZ.weight;
        count[z] = moments[0];
        sum[z] = moments[1];
        squares[z] = moments[2];
    }
    const Float8 mean = sum / count;
    const Float8 variance = squares / count - mean * mean;
    return {mean, squareRoots(variance > 0 ? variance : Float8{})};
}

} // namespace vdblic
