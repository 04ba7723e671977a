#include "vdblic/coherence/cleanness.h"

#include "vdblic/coherence/correlation.h"
#include "vdblic/coherence/random_voxels.h"
#include "vdblic/coherence/smoothed_texture.h"
#include "vdblic/coherence/successor.h"
#include "vdblic/coherence/texture_cube.h"
#include "vdblic/core/paging.h"
#include "vdblic/field/domain_rows.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/pathline.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

namespace vdblic {
namespace {

constexpr double kNoFigure = std::numeric_limits<double>::quiet_NaN();
constexpr int kPointsOfBlock = 512; // one sum for each block of points: a fixed order of additions for any threads
constexpr float kIsolated = 0.05f;

/// Sums over the points of a class.
struct ClassSums {
    std::size_t points = 0, isolated = 0;
    double line = 0, sum = 0, squares = 0;
    std::vector<float> cosines; // of the angles between lines and velocity
    Correlation temporal, samePlace;

    void add(const ClassSums& other)
    {
        points += other.points;
        isolated += other.isolated;
        line += other.line;
        sum += other.sum;
        squares += other.squares;
        cosines.insert(cosines.end(), other.cosines.begin(), other.cosines.end());
        temporal.add(other.temporal);
        samePlace.add(other.samePlace);
    }
};
using SumsByClass = std::array<ClassSums, kDisplacementClasses.size()>;

struct Measured {
    const SmoothedTexture& texture;
    const SmoothedTexture* next;
    const VelocityField& field;
    const PathlineParams& pathline;
    RandomVoxels voxels;
    std::size_t samples; // number of parts of the domain, each with one sample
};

/// A voxel at which the texture is measured.
struct ClassPoint {
    Float4 position, velocity; // index space of the texture, voxels per step
    std::size_t displacementClass;
    float value;
};

std::optional<std::size_t> classOf(float displacement)
{
    for (std::size_t i = 0; i < kDisplacementClasses.size(); ++i) {
        if (displacement > kDisplacementClasses[i].from && displacement <= kDisplacementClasses[i].to) return i;
    }
    return std::nullopt;
}

/// @return whether all voxels have values
bool copyAround(const SmoothedTexture& texture, Int4 centre, TextureCube& cube)
{
    for (int x = 0; x < TextureCube::kDim; ++x) {
        for (int y = 0; y < TextureCube::kDim; ++y) {
            const Int4 first = centre + Int4{x, y, 0, 0} - Int4{1, 1, 1, 0} * TextureCube::kRadius;
            if (!texture.copyRow(first, cube.row(x, y))) return false;
        }
    }
    return true;
}

/// Add the spatial figures of the voxels around a point.
void addCube(const TextureCube& cube, Float4 velocity, ClassSums& sums)
{
    ++sums.points;
    sums.isolated += std::size_t(cube.countIsolated(kIsolated));
    TextureCube::forEachInner([&](int x, int y, int z) {
        const double value = double(cube.at(x, y, z)) - 0.5; // limits cancellation
        sums.sum += value;
        sums.squares += value * value;
    });
    const TextureCube::Lines lines = cube.lines();
    sums.line += lines.strength;
    if (!lines.direction) return;
    const openvdb::math::Vec3d flow(velocity[0], velocity[1], velocity[2]);
    sums.cosines.push_back(float(std::abs(lines.direction->dot(flow)) / flow.length()));
}

/// Correlate with the successor, at the end of the pathline and at the same place.
void addSuccessor(const Measured& measured, const std::vector<ClassPoint>& points, SumsByClass& sums)
{
    forSuccessors(measured.field, measured.pathline, *measured.next, points,
                  [&](const ClassPoint& point, const auto& there, const auto& same) {
                      sums[point.displacementClass].temporal.add(point.value, there.raw);
                      sums[point.displacementClass].samePlace.add(point.value, same.raw);
                  });
}

VDBLIC_KERNEL void measureClasses(const Measured& measured, std::size_t block, SumsByClass& sums)
{
    const FrameDomain& domain = measured.field.frameDomain();
    std::vector<ClassPoint> points;
    TextureCube cube;
    const std::size_t first = block * kPointsOfBlock;
    for (std::size_t i = first; i < std::min(first + kPointsOfBlock, measured.samples); ++i) {
        paging::breathe(paging::kPointBytes);
        ClassPoint point;
        point.position = measured.voxels.centreInPart(i, measured.samples);
        const Int4 voxel = voxelOf(point.position);
        const openvdb::Coord coarse = domain.refinement.coarse({{voxel[0], voxel[1], voxel[2]}}).at;
        if (!covers(*domain.velocity, Float4{float(coarse[0]), float(coarse[1]), float(coarse[2]), 0})) continue;
        point.velocity = measured.field.sample(point.position, 0, Float4{0, 0, 0, 0});
        const auto displacementClass = classOf(pathline::length(point.velocity));
        if (!displacementClass || !copyAround(measured.texture, voxel, cube)) continue;
        point.displacementClass = *displacementClass;
        point.value = cube.centre();
        addCube(cube, point.velocity, sums[*displacementClass]);
        points.push_back(point);
    }
    if (measured.next) addSuccessor(measured, points, sums);
}

/// The median of angles in degrees. @param cosines reordered
double medianAngle(std::vector<float>& cosines)
{
    if (cosines.size() < kLeastClassPoints) return kNoFigure;
    const auto middle = cosines.begin() + std::ptrdiff_t(cosines.size() / 2);
    std::nth_element(cosines.begin(), middle, cosines.end());
    return std::acos(std::min(double(*middle), 1.0)) * 180 / std::numbers::pi;
}

Cleanness cleannessOf(ClassSums& sums)
{
    Cleanness figures{sums.points, kNoFigure, kNoFigure, kNoFigure, kNoFigure, kNoFigure, kNoFigure};
    if (sums.points < kLeastClassPoints) return figures;
    const double points = double(sums.points), voxels = points * TextureCube::kInner;
    figures.isolated = double(sums.isolated) / voxels;
    figures.line = sums.line / points;
    figures.angle = medianAngle(sums.cosines);
    const double mean = sums.sum / voxels;
    figures.deviation = std::sqrt(std::max(sums.squares / voxels - mean * mean, 0.0));
    if (sums.temporal.count() >= kLeastClassPoints) {
        figures.temporal = sums.temporal.value();
        figures.samePlace = sums.samePlace.value();
    }
    return figures;
}

} // namespace

CleannessByClass measureCleanness(const SmoothedTexture& texture, const SmoothedTexture* next,
                                  const VelocityField& field, const CoherenceParams& params, std::int64_t frame)
{
    const std::size_t samples = std::min(std::size_t(params.samples), texture.domain().voxelCount());
    const Measured measured{texture, next, field, params.pathline, {texture.domain(), frame}, samples};
    SumsByClass all;
    std::vector<SumsByClass> blocks((samples + kPointsOfBlock - 1) / kPointsOfBlock);
    tbb::parallel_for(std::size_t(0), blocks.size(),
                      [&](std::size_t block) { measureClasses(measured, block, blocks[block]); });
    for (const SumsByClass& block : blocks) {
        for (std::size_t i = 0; i < all.size(); ++i)
            all[i].add(block[i]);
    }
    CleannessByClass result;
    for (std::size_t i = 0; i < all.size(); ++i)
        result[i] = cleannessOf(all[i]);
    return result;
}

} // namespace vdblic
