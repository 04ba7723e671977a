#include "vdblic/volume/texture_volume.h"

#include "vdblic/camera/affine_transform.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/paging.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/mix_bits.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/coarse_scalar.h"
#include "vdblic/volume/leaf_share.h"
#include "vdblic/volume/texture_block.h"

#include <glm/ext/matrix_transform.hpp>
#include <glm/matrix.hpp>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

void checkTransforms(const openvdb::FloatGrid& texture, const openvdb::FloatGrid& scalar)
{
    if (texture.transform() == scalar.transform()) return;
    throw InputError(fmt::format("grids {} and {} have different transforms; resample one onto the other",
                                 texture.getName(), scalar.getName()));
}

/// A scalar on coarser voxels than a sparse texture; nothing if both have the same voxels.
std::optional<CoarseScalar> coarseScalar(const openvdb::FloatGrid& texture, const openvdb::FloatGrid& scalar,
                                         bool isSparse)
{
    std::optional<CoarseScalar> coarse = isSparse ? CoarseScalar::of(scalar, texture) : std::nullopt;
    if (!coarse) checkTransforms(texture, scalar);
    return coarse;
}

/// A rank's part of a domain.
std::shared_ptr<const Domain> partOf(const Domain& whole, const LeafShare& share, int rim)
{
    std::vector<std::uint32_t> own, needed;
    for (std::uint32_t leaf = 0; leaf < whole.leafCount(); ++leaf) {
        if (share.owns(whole.origin(leaf))) own.push_back(leaf);
        if (share.needs(whole.origin(leaf), rim)) needed.push_back(leaf);
    }
    return whole.ofRank(std::move(own), std::move(needed));
}

/// The number of a leaf's first voxel, above 0; its other voxels' follow by their offsets.
std::uint64_t numberOf(const openvdb::Coord& origin)
{
    constexpr int kBits = 21; // of an axis: more than a domain can span
    std::uint64_t number = 1;
    for (int axis = 0; axis < 3; ++axis)
        number = number << kBits | (std::uint64_t(origin[axis] >> LeafVoxel::kLog2Dim) & ((1u << kBits) - 1));
    return number * LeafVoxel::kCount;
}

/// Choose voxels of a leaf by their numbers' bits, mixed. @param rows receives a bit for each voxel
VDBLIC_KERNEL
void chooseVoxels(std::uint64_t firstNumber, std::uint64_t highest, std::uint8_t* rows)
{
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        unsigned chosen = 0;
        for (int z = 0; z < LeafVoxel::kDim; z += 4) {
            const std::uint64_t first = firstNumber + unsigned(row * LeafVoxel::kDim + z);
            const auto isChosen = mixBits(first + UnsignedLong4{0, 1, 2, 3}) <= highest;
            for (int lane = 0; lane < 4; ++lane)
                chosen |= unsigned(isChosen[lane] & 1) << (z + lane);
        }
        rows[row] = std::uint8_t(chosen);
    }
}

} // namespace

TextureVolume::TextureVolume(const openvdb::FloatGrid& texture, const openvdb::FloatGrid& driver,
                             const glm::dvec3& stretch, const RecordUse& use)
    : PlacedBox(glm::scale(glm::dmat4(1), stretch) * affineMatrix(texture.transform(), "grid " + texture.getName())),
      mIsSparse(use.isSparse)
{
    const std::optional<CoarseScalar> coarse = coarseScalar(texture, driver, mIsSparse);
    mDomain = std::make_shared<const Domain>(
        std::make_shared<openvdb::MaskTree>(texture.tree(), false, true, openvdb::TopologyCopy()),
        use.share ? use.share->ranks() : 1);
    if (use.share) mDomain = partOf(domain(), *use.share, use.rim);
    const std::size_t leaves = leafCount();
    constexpr std::size_t kMostLeaves = std::numeric_limits<std::uint32_t>::max() / TextureLeaf::kSize;
    if (leaves > kMostLeaves) {
        throw InputError(fmt::format("grid {} has {} leaves; at most {} can be rendered: cut it into parts",
                                     texture.getName(), leaves, kMostLeaves));
    }
    mRanges.resize(leaves);
    mShown.resize(leaves);
    mHasRecords.resize(leaves);
    mScales.resize(leaves);
    mRecords = std::make_unique_for_overwrite<TextureRecord[]>(leaves * TextureLeaf::kSize);
    mDrivers = ScalarRecords(leaves, coarse);

    // Gradients are covectors. The factor makes them independent of the unit of length.
    mGradientToWorld = glm::mat3(glm::transpose(glm::inverse(glm::dmat3(indexToWorld()))) * voxelSize());

    std::atomic<std::size_t> unusable{0};
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves), [&](const tbb::blocked_range<std::size_t>& some) {
        const auto block = std::make_unique<TextureBlock>();
        for (std::size_t leaf = some.begin(); leaf < some.end(); ++leaf) {
            paging::breathe(paging::kLeafBytes);
            copyLeaf(texture, coarse ? nullptr : &driver, origin(leaf), *block);
            mRanges[leaf] = block->range();
            if (coarse) {
                const auto range = mDrivers.copyCoarse(*coarse, leaf, origin(leaf));
                constexpr float kInfinity = std::numeric_limits<float>::infinity();
                mRanges[leaf].lowDriver = range ? (*range)[0] : kInfinity;
                mRanges[leaf].highDriver = range ? (*range)[1] : -kInfinity;
            }
            mShown[leaf] = domain().mask(domain().local()[leaf]);
            const std::size_t found = block->removeInactive(mShown[leaf]);
            if (found > 0 && isOwn(leaf)) unusable += found;
            // Lanes of the ray caster that have no ray read the first leaf.
            mHasRecords[leaf] = leaf == 0 || !use.look || use.look->contributes(mRanges[leaf]);
            if (!mHasRecords[leaf]) continue;
            block->extend();
            mScales[leaf] = block->writeTexture(mRecords.get() + leaf * TextureLeaf::kSize);
            if (!coarse) block->writeDrivers(mDrivers.values(leaf));
        }
    });
    mUnusable = unusable;

    if (empty()) return;
    openvdb::CoordBBox box;
    domain().topology().evalActiveVoxelBoundingBox(box);
    for (int axis = 0; axis < 3; ++axis) {
        mLow[axis] = box.min()[axis] - 0.5;
        mHigh[axis] = box.max()[axis] + 0.5;
    }
    constexpr double kFarthest = 1e17; // cameras stand farther off, and squares of distances are single precision
    for (const glm::dvec3& corner : corners()) {
        const double farthest = std::max({std::abs(corner.x), std::abs(corner.y), std::abs(corner.z)});
        if (farthest <= kFarthest) continue;
        throw InputError(fmt::format("grid {}: its voxels reach to {:.3g} in world space, and {} at most can be "
                                     "rendered: give its transform another unit of length",
                                     texture.getName(), farthest, kFarthest));
    }
}

void TextureVolume::copyLeaf(const openvdb::FloatGrid& texture, const openvdb::FloatGrid* scalar,
                             const openvdb::Coord& origin, TextureBlock& block) const
{
    const openvdb::FloatTree* const tree = scalar ? &scalar->tree() : nullptr;
    if (mIsSparse) {
        block.copySparse(texture.tree(), tree, origin);
    } else {
        block.copy(texture.tree(), tree, origin);
    }
}

void TextureVolume::addColors(const openvdb::FloatGrid& texture, const openvdb::FloatGrid& colors)
{
    const std::optional<CoarseScalar> coarse = coarseScalar(texture, colors, mIsSparse);
    const std::size_t leaves = leafCount();
    mColors.emplace(leaves, coarse);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves), [&](const tbb::blocked_range<std::size_t>& some) {
        const auto block = std::make_unique<TextureBlock>();
        for (std::size_t leaf = some.begin(); leaf < some.end(); ++leaf) {
            paging::breathe(paging::kLeafBytes);
            if (!mHasRecords[leaf]) continue;
            if (coarse) {
                mColors->copyCoarse(*coarse, leaf, origin(leaf));
                continue;
            }
            copyLeaf(texture, &colors, origin(leaf), *block);
            block->extend();
            block->writeDrivers(mColors->values(leaf));
        }
    });
}

double TextureVolume::bytesPerLeaf() const
{
    const std::size_t scalars = mDrivers.bytesPerLeaf() + (mColors ? mColors->bytesPerLeaf() : 0);
    return bytesPerLeaf(bool(mLines), double(scalars));
}

double TextureVolume::bytesPerLeaf(bool hasLines, double scalarBytes)
{
    constexpr double kTexture = sizeof(TextureRecord) * TextureLeaf::kSize + sizeof(TextureScale) + sizeof(Mask);
    return kTexture + (hasLines ? double(sizeof(LineRecord) * ScalarLeaf::kSize) : 0) + scalarBytes;
}

void TextureVolume::cut(const Domain& kept)
{
    mIsCut = true;
    tbb::parallel_for(std::size_t(0), mShown.size(), [&](std::size_t leaf) {
        const openvdb::Coord c = origin(leaf);
        const int found = kept.findLeaf(Int4{c[0], c[1], c[2]});
        if (found >= 0) {
            mShown[leaf] &= kept.mask(std::size_t(found));
        } else {
            mShown[leaf].setOff();
        }
    });
}

int TextureVolume::findLeaf(const openvdb::Coord& voxel) const
{
    const int found = domain().findLeaf(Int4{voxel[0], voxel[1], voxel[2]});
    if (found < 0 || domain().isWhole()) return found;
    const Domain::Leaves all = domain().local();
    return int(std::lower_bound(all.begin(), all.end(), std::uint32_t(found)) - all.begin());
}

VolumeSamples TextureVolume::samples() const
{
    constexpr std::uint64_t kMost = 1 << 18, kAll = std::numeric_limits<std::uint64_t>::max();
    const std::uint64_t voxels = domain().voxelCount(), highest = voxels <= kMost ? kAll : kAll / voxels * kMost;
    const auto add = [&](std::size_t leaf, VolumeSamples& samples) {
        if (!isOwn(leaf)) return;
        std::uint8_t chosen[LeafVoxel::kRows];
        chooseVoxels(numberOf(origin(leaf)), highest, chosen);
        for (int row = 0; row < LeafVoxel::kRows; ++row) {
            const LeafVoxel first = LeafVoxel::ofRow(row);
            const TextureRecord* const texture = records(leaf) + TextureLeaf::index(first.x, first.y, 0);
            unsigned left = chosen[row] & mShown[leaf].getWord<std::uint8_t>(openvdb::Index(row));
            for (; left != 0; left &= left - 1) {
                const int z = std::countr_zero(left);
                samples.texture.push_back(mScales[leaf].low + float(texture[z]) * mScales[leaf].perUnit);
                samples.driver.push_back(mDrivers.row(leaf, first.x, first.y)[z]);
                if (mColors) samples.color.push_back(mColors->row(leaf, first.x, first.y)[z]);
            }
        }
    };
    constexpr std::size_t kLeaves = 256; // of a part
    std::vector<VolumeSamples> parts((leafCount() + kLeaves - 1) / kLeaves);
    tbb::parallel_for(std::size_t(0), parts.size(), [&](std::size_t part) {
        for (std::size_t leaf = part * kLeaves; leaf < std::min(leafCount(), (part + 1) * kLeaves); ++leaf)
            add(leaf, parts[part]);
    });
    VolumeSamples all;
    for (const VolumeSamples& part : parts)
        all.append(part);
    return all;
}

} // namespace vdblic
