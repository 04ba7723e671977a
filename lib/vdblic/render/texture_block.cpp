#include "vdblic/render/texture_block.h"

#include <cmath>
#include <cstring>

namespace vdblic {
namespace {

/// Copy what one node or tile holds of a block, for each of the 27 leaves that a block meets.
template<typename Visit>
void visitLeaves(const openvdb::FloatTree& tree, const openvdb::Coord& origin, const Visit& visit)
{
    constexpr int kBegin[] = {-2, 0, 8}, kEnd[] = {0, 8, 10};
    const openvdb::tree::ValueAccessor<const openvdb::FloatTree> accessor(tree);
    for (int part = 0; part < 27; ++part) {
        const int p[] = {part / 9, part / 3 % 3, part % 3};
        const openvdb::Coord begin(kBegin[p[0]], kBegin[p[1]], kBegin[p[2]]), end(kEnd[p[0]], kEnd[p[1]], kEnd[p[2]]);
        const openvdb::FloatTree::LeafNodeType* leaf = accessor.probeConstLeaf(origin + begin);
        float tile = 0;
        const bool active = !leaf && accessor.probeValue(origin + begin, tile);
        visit(begin, end, leaf, tile, active);
    }
}

/// The derivative along one axis from the neighbours that are there, in texture per voxel.
float difference(const float* value, const bool* active, int stride)
{
    const bool before = active[-stride], after = active[stride];
    if (before && after) return (value[stride] - value[-stride]) * 0.5f;
    if (after) return value[stride] - *value;
    return before ? *value - value[-stride] : 0.0f;
}

} // namespace

void TextureBlock::copy(const openvdb::FloatTree& texture, const openvdb::FloatTree& magnitude,
                        const openvdb::Coord& origin)
{
    const auto row = [](int x, int y) { return Domain::offset(Int4{x, y, 0, 0}); };
    bool whole = true;
    visitLeaves(texture, origin, [&](auto begin, auto end, const auto* leaf, float tile, bool active) {
        for (int x = begin[0]; x < end[0]; ++x) {
            for (int y = begin[1]; y < end[1]; ++y) {
                for (int z = begin[2]; z < end[2]; ++z) {
                    const int i = index(x, y, z);
                    const unsigned offset = row(x, y) + unsigned(z & 7);
                    mTexture[i] = leaf ? leaf->buffer().data()[offset] : tile;
                    mActive[i] = (leaf ? leaf->isValueOn(offset) : active) && std::isfinite(mTexture[i]);
                    whole &= mActive[i];
                }
            }
        }
    });
    visitLeaves(magnitude, origin, [&](auto begin, auto end, const auto* leaf, float tile, bool) {
        for (int x = begin[0]; x < end[0]; ++x) {
            for (int y = begin[1]; y < end[1]; ++y) {
                for (int z = begin[2]; z < end[2]; ++z) {
                    const int i = index(x, y, z);
                    mMagnitude[i] = leaf ? leaf->buffer().data()[row(x, y) + unsigned(z & 7)] : tile;
                    if (!std::isfinite(mMagnitude[i])) whole = mActive[i] = false;
                }
            }
        }
    });
    mWhole = whole;
}

void TextureBlock::extend()
{
    if (mWhole) return;
    for (int x = -1; x <= 8; ++x) {
        for (int y = -1; y <= 8; ++y) {
            for (int z = -1; z <= 8; ++z) {
                const int i = index(x, y, z);
                if (mActive[i]) continue;
                float texture[4] = {}, magnitude[4] = {}, count[4] = {}; // by how many axes a neighbour differs along
                for (int n = 0; n < 27; ++n) {
                    const int dx = n / 9 - 1, dy = n / 3 % 3 - 1, dz = n % 3 - 1;
                    const int j = i + (dx * kDim + dy) * kDim + dz;
                    if (!mActive[j]) continue;
                    const int distance = (dx != 0) + (dy != 0) + (dz != 0);
                    texture[distance] += mTexture[j];
                    magnitude[distance] += mMagnitude[j];
                    count[distance] += 1;
                }
                mTexture[i] = mMagnitude[i] = 0;
                for (int distance = 1; distance <= 3; ++distance) {
                    if (count[distance] == 0) continue;
                    mTexture[i] = texture[distance] / count[distance];
                    mMagnitude[i] = magnitude[distance] / count[distance];
                    break;
                }
            }
        }
    }
}

LeafRange TextureBlock::range() const
{
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    LeafRange range{kInfinity, -kInfinity, -kInfinity};
    for (int x = -1; x <= 8; ++x) {
        for (int y = -1; y <= 8; ++y) {
            for (int z = -1; z <= 8; ++z) {
                const int i = index(x, y, z);
                if (!mActive[i]) continue;
                range.lowMagnitude = std::min(range.lowMagnitude, mMagnitude[i]);
                range.highMagnitude = std::max(range.highMagnitude, mMagnitude[i]);
                range.highTexture = std::max(range.highTexture, mTexture[i]);
            }
        }
    }
    return range;
}

void TextureBlock::writeValues(ValueRecord* brick) const
{
    for (int x = -1; x <= 8; ++x) {
        for (int y = -1; y <= 8; ++y) {
            const int i = index(x, y, -1);
            ValueRecord* row = brick + brickIndex(x, y, -1);
            for (int z = 0; z < kBrickDim; ++z)
                row[z] = {mTexture[i + z], mMagnitude[i + z]};
        }
    }
}

void TextureBlock::writeGradients(const glm::mat3& gradientToWorld, GradientRecord* brick) const
{
    constexpr int kStrides[] = {kDim * kDim, kDim, 1};
    for (int x = -1; x <= 8; ++x) {
        for (int y = -1; y <= 8; ++y) {
            const int i = index(x, y, -1);
            GradientRecord* row = brick + brickIndex(x, y, -1);
            for (int z = 0; z < kBrickDim; ++z) {
                const float* value = mTexture + i + z;
                glm::vec3 gradient;
                for (int axis = 0; axis < 3; ++axis) {
                    gradient[axis] = mWhole ? (value[kStrides[axis]] - value[-kStrides[axis]]) * 0.5f
                                            : difference(value, mActive + i + z, kStrides[axis]);
                }
                if (!mActive[i + z]) gradient = glm::vec3(0);
                gradient = gradientToWorld * gradient;
                row[z] = {{halfFloat(gradient.x), halfFloat(gradient.y), halfFloat(gradient.z), 0}};
            }
        }
    }
}

std::size_t TextureBlock::removeInactive(TextureVolume::Mask& mask) const
{
    if (mWhole) return 0;
    std::size_t removed = 0;
    for (auto i = mask.beginOn(); i; ++i) {
        const auto offset = int(i.pos());
        if (mActive[index(offset >> 6, offset >> 3 & 7, offset & 7)]) continue;
        mask.setOff(i.pos());
        ++removed;
    }
    return removed;
}

} // namespace vdblic
