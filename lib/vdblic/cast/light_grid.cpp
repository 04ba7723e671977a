#include "vdblic/cast/light_grid.h"

#include "vdblic/camera/camera.h"
#include "vdblic/cast/solid.h"
#include "vdblic/core/exchange.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/texture_volume.h"

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdblic {
namespace {

constexpr std::size_t kMostCells = 1 << 20;
constexpr float kSolidExtinction = 10; // per voxel

/// The extinctions of a row of a leaf's voxels along z, hidden ones 0.
VDBLIC_INLINE Float8 rowExtinctions(const TextureVolume& volume, const Look& look, std::size_t leaf, int x, int y)
{
    const ValueRecord* row = volume.values() + leaf * kPaddedSize + std::size_t(paddedIndex(x, y, 0));
    Float8 texture, driver, result{};
    for (int z = 0; z < kLanes; ++z) {
        texture[z] = row[z].texture;
        driver[z] = row[z].driver;
    }
    const Int8 entries = look.transfer.entries(driver);
    const Float8 density = look.texture.density(look.texture.stretched(texture));
    for (int z = 0; z < kLanes; ++z) {
        const bool shown = volume.shown(leaf).isOn(unsigned(LeafVoxel::offset(x, y, z)));
        result[z] = shown ? look.transfer.extinctions()[entries[z]] * density[z] : 0;
    }
    return result;
}

} // namespace

glm::dvec3 keyLight(const Look& look, const Camera& camera)
{
    if (!look.shading.lights.empty()) return look.shading.lights.front().direction;
    const glm::dmat3 toWorld = glm::transpose(glm::dmat3(camera.worldToCamera()));
    return toWorld * glm::dvec3(-0.5, 0.8, -0.35);
}

LightGrid::LightGrid(const TextureVolume& volume, const Look& look, const glm::dvec3& towardsLight, double strength,
                     const Solid* solid, Exchange& exchange)
{
    openvdb::CoordBBox box;
    for (std::size_t leaf = 0; leaf < volume.domain().leafCount(); ++leaf)
        box.expand(openvdb::CoordBBox::createCube(volume.domain().origin(leaf), LeafVoxel::kDim));
    if (box.empty()) box = {openvdb::Coord(0), openvdb::Coord(0)};
    mOrigin = box.min();
    const auto cells = [&] {
        for (int axis = 0; axis < 3; ++axis)
            mDim[axis] = (box.max()[axis] - mOrigin[axis]) / mCell + 1;
        return double(mDim[0]) * mDim[1] * mDim[2];
    };
    while (cells() > double(kMostCells))
        mCell *= 2;
    std::vector<float> extinctions = meanExtinctions(volume, look, exchange);
    if (solid) addSolid(volume, *solid, extinctions);
    const glm::dmat3 toIndex(volume.worldToIndex());
    sweep(toIndex * towardsLight, extinctions);
    for (float& factor : mFactors)
        factor = float(1 - strength * (1 - std::exp(-double(factor))));
}

/// Sums are of integers, so their order does not matter.
std::vector<float> LightGrid::meanExtinctions(const TextureVolume& volume, const Look& look, Exchange& exchange) const
{
    constexpr float kUnit = 0x1p32f;
    std::vector<std::uint64_t> sums(index(mDim.offsetBy(-1)) + 1);
    const auto addLeaf = [&](std::size_t leaf) {
        if (!volume.isOwn(leaf) || volume.shown(leaf).isOff() || !look.contributes(volume.leafRange(leaf))) return;
        const openvdb::Coord from = volume.origin(leaf) - mOrigin;
        for (int x = 0; x < LeafVoxel::kDim; ++x) {
            for (int y = 0; y < LeafVoxel::kDim; ++y) {
                const Float8 row = rowExtinctions(volume, look, leaf, x, y);
                for (int z = 0; z < LeafVoxel::kDim; ++z) {
                    const openvdb::Coord voxel = from.offsetBy(x, y, z);
                    sums[index({voxel[0] / mCell, voxel[1] / mCell, voxel[2] / mCell})] +=
                        std::uint64_t(row[z] * kUnit);
                }
            }
        }
    };
    // A cell that is larger than a leaf gets the sums of several, one after the other.
    if (mCell <= LeafVoxel::kDim) {
        tbb::parallel_for(std::size_t(0), volume.leafCount(), addLeaf);
    } else {
        for (std::size_t leaf = 0; leaf < volume.leafCount(); ++leaf)
            addLeaf(leaf);
    }
    exchange.sum(sums);
    const double perSum = 1 / (double(kUnit) * mCell * mCell * mCell);
    std::vector<float> means;
    means.reserve(sums.size());
    for (const std::uint64_t sum : sums)
        means.push_back(float(double(sum) * perSum));
    return means;
}

void LightGrid::addSolid(const TextureVolume& volume, const Solid& solid, std::vector<float>& extinctions) const
{
    const glm::dmat4 toSolid = solid.worldToIndex * volume.indexToWorld();
    tbb::parallel_for(0, mDim[0], [&](int x) {
        const auto values = solid.levelSet->getConstAccessor();
        for (int y = 0; y < mDim[1]; ++y) {
            for (int z = 0; z < mDim[2]; ++z) {
                const glm::dvec3 cell(x + 0.5, y + 0.5, z + 0.5);
                const glm::dvec3 middle = glm::dvec3(mOrigin[0], mOrigin[1], mOrigin[2]) + cell * double(mCell) - 0.5;
                const glm::dvec4 at = toSolid * glm::dvec4(middle, 1);
                if (values.getValue(openvdb::Coord::round(openvdb::Vec3d(at.x, at.y, at.z))) < 0)
                    extinctions[index({x, y, z})] = kSolidExtinction;
            }
        }
    });
}

/// Replace the extinctions by the optical depths at the cells' centres.
void LightGrid::sweep(const glm::dvec3& towardsLight, std::vector<float>& extinctions)
{
    int along = 0;
    for (int axis = 1; axis < 3; ++axis) {
        if (std::abs(towardsLight[axis]) > std::abs(towardsLight[along])) along = axis;
    }
    const int first = (along + 1) % 3, second = (along + 2) % 3;
    const bool up = towardsLight[along] > 0;
    // From a cell's centre to where its light passes the middle of the slab before [cells], and that way's length
    // [voxels].
    const double firstShift = towardsLight[first] / std::abs(towardsLight[along]);
    const double secondShift = towardsLight[second] / std::abs(towardsLight[along]);
    const auto half = float(0.5 * mCell * glm::length(towardsLight) / std::abs(towardsLight[along]));
    mFactors.assign(extinctions.size(), 0);
    std::vector<float> leaving(extinctions.size()); // optical depth where light leaves a cell for the slab behind
    for (int slab = 0; slab < mDim[along]; ++slab) {
        tbb::parallel_for(0, mDim[first], [&](int i) {
            openvdb::Coord cell;
            cell[along] = up ? mDim[along] - 1 - slab : slab;
            cell[first] = i;
            for (int j = 0; j < mDim[second]; ++j) {
                cell[second] = j;
                float arriving = 0;
                if (slab > 0) {
                    const double u = i + firstShift, v = j + secondShift;
                    const int low[] = {int(std::floor(u)), int(std::floor(v))};
                    for (int corner = 0; corner < 4; ++corner) {
                        openvdb::Coord before = cell;
                        before[along] += up ? 1 : -1;
                        before[first] = low[0] + (corner & 1);
                        before[second] = low[1] + (corner >> 1);
                        if (before[first] < 0 || before[first] >= mDim[first] || before[second] < 0 ||
                            before[second] >= mDim[second])
                            continue; // outside the volume all light arrives
                        const double share = (corner & 1 ? u - low[0] : 1 - (u - low[0])) *
                                             (corner >> 1 ? v - low[1] : 1 - (v - low[1]));
                        arriving += float(share) * leaving[index(before)];
                    }
                }
                const std::size_t at = index(cell);
                mFactors[at] = arriving + half * extinctions[at];
                leaving[at] = mFactors[at] + half * extinctions[at];
            }
        });
    }
}

void LightGrid::at(const Float8* position, Float8& result) const
{
    Int8 cell[3];
    Float8 fraction[3];
    for (int axis = 0; axis < 3; ++axis) {
        // Cell centres lie at origin + cell · (c + ½) − ½.
        const Float8 at = (position[axis] - float(mOrigin[axis]) + 0.5f) / float(mCell) - 0.5f;
        const float last = float(std::max(mDim[axis] - 2, 0));
        const Float8 inside = at > 0 ? at : Float8{};
        cell[axis] = __builtin_convertvector(inside < last ? inside : broadcast8(last), Int8);
        const Float8 rest = inside - __builtin_convertvector(cell[axis], Float8);
        fraction[axis] = rest < 1 ? rest : broadcast8(1);
    }
    result = Float8{};
    for (int lane = 0; lane < kLanes; ++lane) {
        const openvdb::Coord low(cell[0][lane], cell[1][lane], cell[2][lane]);
        for (int corner = 0; corner < 8; ++corner) {
            openvdb::Coord at = low;
            float share = 1;
            for (int axis = 0; axis < 3; ++axis) {
                const bool high = corner >> axis & 1;
                share *= high ? fraction[axis][lane] : 1 - fraction[axis][lane];
                at[axis] = std::min(at[axis] + int(high), mDim[axis] - 1);
            }
            result[lane] += share * mFactors[index(at)];
        }
    }
}

float LightGrid::at(const glm::dvec3& position) const
{
    const Float8 all[] = {broadcast8(float(position.x)), broadcast8(float(position.y)), broadcast8(float(position.z))};
    Float8 result;
    at(all, result);
    return result[0];
}

} // namespace vdblic
