#include "vdblic/field/refinement.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/field/leaf_voxel.h"

#include <fmt/format.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::MaskTree;
using openvdb::Vec3d;
using MaskLeaf = MaskTree::LeafNodeType;

int floorDivide(int number, int divisor)
{
    return (number >= 0 ? number : number - divisor + 1) / divisor;
}

/// The n-th block of a cube with `factors` blocks along each axis, x slowest.
Coord blockOf(int n, const std::array<int, 3>& factors)
{
    return {n / (factors[1] * factors[2]), n / factors[2] % factors[1], n % factors[2]};
}

Coord firstOf(const Coord& velocityVoxel, const std::array<int, 3>& factors)
{
    return {velocityVoxel[0] * factors[0], velocityVoxel[1] * factors[1], velocityVoxel[2] * factors[2]};
}

/// The mask of a texture leaf over a velocity leaf. @param block number of the texture leaf along each axis
MaskLeaf::NodeMaskType refinedMask(const MaskLeaf::NodeMaskType& velocity, const Coord& block,
                                   const std::array<int, 3>& factors)
{
    if (velocity.isOn()) return velocity;
    const auto below = [&](int axis, int voxel) {
        return (block[axis] * LeafVoxel::kDim + voxel) / factors[std::size_t(axis)];
    };
    MaskLeaf::NodeMaskType mask(false);
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const LeafVoxel voxel = LeafVoxel::ofRow(row);
        const auto under =
            velocity.getWord<std::uint8_t>(openvdb::Index(LeafVoxel::row(below(0, voxel.x), below(1, voxel.y))));
        if (under == 0) continue;
        unsigned bits = 0;
        for (int z = 0; z < LeafVoxel::kDim; ++z)
            bits |= unsigned(under >> below(2, z) & 1) << z;
        mask.getWord<std::uint8_t>(openvdb::Index(row)) = std::uint8_t(bits);
    }
    return mask;
}

} // namespace

Parameter refineParameter(std::string_view text, Refinement& refinement)
{
    const auto read = [&refinement](const Words& words) {
        if (words.size() == 2) throw ParameterError("`refine` takes one number, or one for each of the three axes");
        for (std::size_t axis = 0; axis < 3; ++axis)
            refinement.factors[axis] = int(detail::integerIn(words[words.size() == 1 ? 0 : axis]).value());
        refinement.isGiven = true;
    };
    const auto write = [&refinement]() -> Words {
        const auto& [x, y, z] = refinement.factors;
        if (x == y && y == z) return {fmt::format("{}", x)};
        return {fmt::format("{}", x), fmt::format("{}", y), fmt::format("{}", z)};
    };
    Parameter result = parameter("refine", text, WordType::kInteger, 1, read, write,
                                 {.words = "N or NX NY NZ", .limits = {1, Refinement::kMost}});
    result.most = 3;
    return result;
}

void Refinement::validate() const
{
    Refinement copy = *this;
    checkLimits({refineParameter("", copy)});
}

openvdb::Mat3d Refinement::toTexture() const
{
    openvdb::Mat3d result = openvdb::Mat3d::identity();
    for (int axis = 0; axis < 3; ++axis)
        result(axis, axis) = factors[std::size_t(axis)];
    return result;
}

Voxel<Space::kVelocity> Refinement::coarse(const Voxel<Space::kTexture>& voxel) const
{
    const Coord& at = voxel.at;
    return {{floorDivide(at[0], factors[0]), floorDivide(at[1], factors[1]), floorDivide(at[2], factors[2])}};
}

int Refinement::coarseLeaf(int leaf, int axis) const
{
    return floorDivide(leaf, factors[std::size_t(axis)]);
}

openvdb::math::Transform::Ptr Refinement::refined(const openvdb::math::Transform& velocity) const
{
    auto texture = velocity.copy();
    if (isNone()) return texture;
    const Vec3d scale = Vec3d(1) / Vec3d(factors[0], factors[1], factors[2]);
    texture->preTranslate(0.5 * scale - Vec3d(0.5));
    texture->preScale(scale);
    return texture;
}

std::optional<Refinement> Refinement::between(const openvdb::math::Transform& velocity,
                                              const openvdb::math::Transform& texture)
{
    Refinement refinement;
    const Vec3d ratio = velocity.voxelSize() / texture.voxelSize();
    for (int axis = 0; axis < 3; ++axis) {
        if (!(ratio[axis] > 0.5 && ratio[axis] < kMost + 0.5)) return std::nullopt;
        refinement.factors[std::size_t(axis)] = int(std::lround(ratio[axis]));
    }
    if (*refinement.refined(velocity) != texture) return std::nullopt;
    return refinement;
}

Period Refinement::refined(const Period& velocity) const
{
    return {firstOf(velocity.first, factors), firstOf(velocity.size, factors)};
}

MaskTree::Ptr Refinement::refined(const MaskTree& velocity, int ranks) const
{
    const auto each = std::uint64_t(voxels());
    checkVoxels(velocity.activeVoxelCount() * each, "", ranks, velocity.activeLeafVoxelCount() * each);
    MaskTree expanded(velocity);
    expanded.voxelizeActiveTiles();
    const openvdb::tree::LeafManager<const MaskTree> leaves(expanded);
    std::vector<std::vector<std::unique_ptr<MaskLeaf>>> made(leaves.leafCount()); // by velocity leaf
    tbb::parallel_for(std::size_t(0), leaves.leafCount(), [&](std::size_t i) {
        const MaskLeaf& coarseLeaf = leaves.leaf(i);
        const Coord first = firstOf(coarseLeaf.origin(), factors);
        for (int n = 0; n < voxels(); ++n) {
            const Coord block = blockOf(n, factors);
            auto leaf = std::make_unique<MaskLeaf>(
                first.offsetBy(block[0] * LeafVoxel::kDim, block[1] * LeafVoxel::kDim, block[2] * LeafVoxel::kDim),
                false);
            leaf->setValueMask(refinedMask(coarseLeaf.getValueMask(), block, factors));
            if (!leaf->isEmpty()) made[i].push_back(std::move(leaf));
        }
    });
    auto texture = std::make_shared<MaskTree>();
    for (auto& some : made) {
        for (auto& leaf : some)
            texture->addLeaf(leaf.release());
    }
    return texture;
}

MaskTree::Ptr Refinement::coarsened(const MaskTree& texture, const MaskTree& velocity) const
{
    auto result = std::make_shared<MaskTree>(velocity);
    result->voxelizeActiveTiles();
    openvdb::tree::LeafManager<MaskTree> leaves(*result);
    leaves.foreach ([&](MaskLeaf& leaf, std::size_t) {
        const openvdb::tree::ValueAccessor<const MaskTree> inTexture(texture);
        const auto hasTexture = [&](const Coord& voxel) {
            const Coord first = firstOf(voxel, factors);
            for (int n = 0; n < voxels(); ++n) {
                if (inTexture.isValueOn(first + blockOf(n, factors))) return true;
            }
            return false;
        };
        const auto mask = leaf.getValueMask();
        for (auto voxel = mask.beginOn(); voxel; ++voxel) {
            if (!hasTexture(leaf.offsetToGlobalCoord(voxel.pos()))) leaf.setValueOff(voxel.pos());
        }
    });
    return result;
}

} // namespace vdblic
