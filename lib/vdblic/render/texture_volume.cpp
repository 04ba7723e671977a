#include "vdblic/render/texture_volume.h"

#include "vdblic/core/errors.h"

#include <glm/matrix.hpp>

#include <atomic>
#include <cmath>

namespace vdblic {
namespace {

glm::dmat4 affine(const openvdb::FloatGrid& grid)
{
    if (!grid.transform().isLinear()) {
        throw InputError(fmt::format("grid {} has a {} transform; only affine ones can be rendered: resample it first",
                                     grid.getName(), grid.transform().mapType()));
    }
    const openvdb::Mat4d matrix = grid.transform().baseMap()->getAffineMap()->getMat4();
    glm::dmat4 result;
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j)
            result[i][j] = matrix[i][j]; // OpenVDB's rows are GLM's columns
    }
    if (!(std::abs(glm::determinant(glm::dmat3(result))) > 0) || !std::isfinite(glm::determinant(result))) {
        throw InputError(
            fmt::format("grid {} has a transform that flattens space; give its voxels a size", grid.getName()));
    }
    return result;
}

/// A leaf and the voxels its records' gradients need: one below and two above along each axis.
constexpr int kReach = 11;
constexpr int kBlock = kReach * kReach * kReach;

constexpr int blockIndex(int x, int y, int z)
{
    return ((x + 1) * kReach + y + 1) * kReach + z + 1;
}

/// Copy such a block out of a tree. @param active may be null
void copyBlock(const openvdb::FloatTree& tree, const openvdb::Coord& origin, float* values, bool* active)
{
    constexpr int kBegin[] = {-1, 0, 8}, kEnd[] = {0, 8, 10};
    for (int part = 0; part < 27; ++part) {
        const int px = part / 9, py = part / 3 % 3, pz = part % 3;
        const openvdb::Coord first = origin.offsetBy(kBegin[px], kBegin[py], kBegin[pz]);
        const openvdb::FloatTree::LeafNodeType* leaf = tree.probeConstLeaf(first);
        float tile = 0;
        const bool tileActive = !leaf && tree.probeValue(first, tile);
        for (int x = kBegin[px]; x < kEnd[px]; ++x) {
            for (int y = kBegin[py]; y < kEnd[py]; ++y) {
                for (int z = kBegin[pz]; z < kEnd[pz]; ++z) {
                    const unsigned offset = Domain::offset(Int4{x, y, z, 0});
                    values[blockIndex(x, y, z)] = leaf ? leaf->getValue(offset) : tile;
                    if (active) active[blockIndex(x, y, z)] = leaf ? leaf->isValueOn(offset) : tileActive;
                }
            }
        }
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

struct Block {
    float texture[kBlock], magnitude[kBlock];
    bool active[kBlock];
};

void fillRecords(const Block& block, const glm::mat3& gradientToWorld, Record* records)
{
    for (int x = 0; x < Bricks::kDim; ++x) {
        for (int y = 0; y < Bricks::kDim; ++y) {
            for (int z = 0; z < Bricks::kDim; ++z) {
                const int i = blockIndex(x, y, z);
                Record& record = records[(x * Bricks::kDim + y) * Bricks::kDim + z];
                record = {};
                if (!block.active[i]) continue;
                const float* value = block.texture + i;
                const bool* active = block.active + i;
                const glm::vec3 gradient =
                    gradientToWorld * glm::vec3(difference(value, active, kReach * kReach),
                                                difference(value, active, kReach), difference(value, active, 1));
                record.values[TextureVolume::kTexture] = *value;
                record.values[TextureVolume::kMagnitude] = block.magnitude[i];
                record.values[TextureVolume::kCoverage] = 1;
                record.values[TextureVolume::kGradientX] = gradient.x;
                record.values[TextureVolume::kGradientY] = gradient.y;
                record.values[TextureVolume::kGradientZ] = gradient.z;
            }
        }
    }
}

LeafRange rangeOf(const Block& block)
{
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    LeafRange range{kInfinity, -kInfinity, -kInfinity};
    for (int x = -1; x <= 8; ++x) {
        for (int y = -1; y <= 8; ++y) {
            for (int z = -1; z <= 8; ++z) {
                const int i = blockIndex(x, y, z);
                if (!block.active[i]) continue;
                range.lowMagnitude = std::min(range.lowMagnitude, block.magnitude[i]);
                range.highMagnitude = std::max(range.highMagnitude, block.magnitude[i]);
                range.highTexture = std::max(range.highTexture, block.texture[i]);
            }
        }
    }
    return range;
}

} // namespace

TextureVolume::TextureVolume(const openvdb::FloatGrid& texture, const openvdb::FloatGrid& magnitude)
    : mIndexToWorld(affine(texture)), mWorldToIndex(glm::inverse(mIndexToWorld))
{
    if (texture.transform() != magnitude.transform()) {
        throw InputError(fmt::format("grids {} and {} have different transforms; resample one onto the other",
                                     texture.getName(), magnitude.getName()));
    }
    auto domain = std::make_shared<const Domain>(
        std::make_shared<openvdb::MaskTree>(texture.tree(), false, true, openvdb::TopologyCopy()));
    mRanges.resize(domain->leafCount());

    // Gradients are covectors; scaled so that a step of one voxel counts the same in any unit of length.
    const glm::dmat3 linear(mIndexToWorld);
    const double voxelSize = std::cbrt(std::abs(glm::determinant(linear)));
    const glm::mat3 gradientToWorld(glm::transpose(glm::inverse(linear)) * voxelSize);

    std::atomic<std::size_t> unusable{0};
    const Domain& leaves = *domain;
    mBricks.fill(std::move(domain), [&](std::size_t leaf, Record* records) {
        Block block;
        copyBlock(texture.tree(), leaves.origin(leaf), block.texture, block.active);
        copyBlock(magnitude.tree(), leaves.origin(leaf), block.magnitude, nullptr);
        std::size_t found = 0;
        for (int i = 0; i < kBlock; ++i) {
            if (!block.active[i] || (std::isfinite(block.texture[i]) && std::isfinite(block.magnitude[i]))) continue;
            block.active[i] = false;
            ++found;
        }
        if (found > 0) unusable += found;
        fillRecords(block, gradientToWorld, records);
        mRanges[leaf] = rangeOf(block);
    });
    mUnusable = unusable;

    if (empty()) return;
    openvdb::CoordBBox box;
    leaves.topology().evalActiveVoxelBoundingBox(box);
    for (int axis = 0; axis < 3; ++axis) {
        mLow[axis] = box.min()[axis] - 0.5;
        mHigh[axis] = box.max()[axis] + 0.5;
    }
}

Corners TextureVolume::corners() const
{
    Corners result;
    for (unsigned i = 0; i < 8; ++i) {
        const glm::dvec3 corner(i & 1 ? mHigh.x : mLow.x, i & 2 ? mHigh.y : mLow.y, i & 4 ? mHigh.z : mLow.z);
        result[i] = glm::dvec3(mIndexToWorld * glm::dvec4(corner, 1));
    }
    return result;
}

TextureVolume::Samples TextureVolume::samples() const
{
    constexpr std::size_t kMost = 1 << 18;
    const std::size_t stride = domain().voxelCount() / kMost + 1;
    Samples result;
    std::size_t voxel = 0;
    for (std::size_t leaf = 0; leaf < domain().leafCount(); ++leaf) {
        for (auto i = domain().mask(leaf).beginOn(); i; ++i) {
            if (voxel++ % stride != 0) continue;
            const openvdb::Coord c =
                domain().origin(leaf) + openvdb::Coord(i.pos() >> 6, i.pos() >> 3 & 7, i.pos() & 7);
            const float* values = mBricks.locate(Float4{float(c[0]), float(c[1]), float(c[2])}).corner->values;
            if (values[kCoverage] == 0) continue;
            result.texture.push_back(values[kTexture]);
            result.magnitude.push_back(values[kMagnitude]);
        }
    }
    return result;
}

} // namespace vdblic
