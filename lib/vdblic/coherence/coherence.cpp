#include "vdblic/coherence/coherence.h"

#include "vdblic/coherence/cleanness.h"
#include "vdblic/coherence/correlation.h"
#include "vdblic/coherence/random_voxels.h"
#include "vdblic/coherence/smoothed_texture.h"
#include "vdblic/coherence/successor.h"
#include "vdblic/core/paging.h"
#include "vdblic/field/domain_rows.h"
#include "vdblic/field/position.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/pathline.h"

#include <openvdb/openvdb.h>
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

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int kBlockPoints = 512; // one sum for each block of points: a fixed order of additions for any threads

/// The correlations of a texture, raw or smoothed.
struct Correlations {
    Correlation temporal, samePlace;
    std::vector<Correlation> along, across; // by lag

    explicit Correlations(std::size_t lags) : along(lags), across(lags) {}
    void add(const Correlations& other)
    {
        temporal.add(other.temporal);
        samePlace.add(other.samePlace);
        for (std::size_t lag = 0; lag < along.size(); ++lag) {
            along[lag].add(other.along[lag]);
            across[lag].add(other.across[lag]);
        }
    }
};

struct BlockSums {
    Correlations raw, smoothed;

    explicit BlockSums(std::size_t lags) : raw(lags), smoothed(lags) {}
};

/// A point at which the texture is sampled.
struct Point {
    Float4 position, velocity; ///< index space of the texture, voxels per step
    SmoothedTexture::Sample here;
    float turn; ///< selects the perpendicular direction, 0 to 1
};

struct Scene {
    const SmoothedTexture& texture;
    const SmoothedTexture* next;
    const VelocityField& field;
    const CoherenceParams& params;
    std::vector<double> lags;
    RandomVoxels voxels;
    IndexSpaces spaces;
};

/// A number in [0, 1) of 24 random bits: exact in single precision.
float unit(std::uint64_t bits)
{
    return float(bits >> 40) * 0x1p-24f;
}

Float4 positionOf(const Scene& scene, std::uint64_t hash)
{
    const std::uint64_t x = mixBits(hash), y = mixBits(x), z = mixBits(y);
    return scene.voxels.centre(hash) + Float4{unit(x), unit(y), unit(z), 0.5f} - 0.5f;
}

/// The point with a number, if it counts.
std::optional<Point> pointOf(const Scene& scene, std::uint64_t number)
{
    const std::uint64_t hash = scene.voxels.hash(number);
    Point point;
    point.position = positionOf(scene, hash);
    point.turn = unit(mixBits(~hash));
    point.here = scene.texture.sample(point.position);
    if (!point.here.inside) return std::nullopt;
    if (!covers(*scene.field.frameDomain().velocity, scene.spaces.velocity({point.position}).at)) return std::nullopt;
    point.velocity = scene.field.sample(point.position, 0, Float4{0, 0, 0, 0});
    if (!(pathline::length(point.velocity * scene.spaces.scale()) >= scene.params.leastMotion)) return std::nullopt;
    return point;
}

/// Correlate with the successor, at the same position and at the end of the pathline.
void addTemporal(const Scene& scene, const std::vector<Point>& points, BlockSums& sums)
{
    forSuccessors(scene.field, scene.params.pathline, *scene.next, points,
                  [&](const Point& point, const auto& there, const auto& same) {
                      sums.raw.temporal.add(point.here.raw, there.raw);
                      sums.raw.samePlace.add(point.here.raw, same.raw);
                      sums.smoothed.temporal.add(point.here.smoothed, there.smoothed);
                      sums.smoothed.samePlace.add(point.here.smoothed, same.smoothed);
                  });
}

/// The position a distance further along the streamline, by the midpoint rule; over half a voxel of the velocity its
/// error is far below a voxel. @param distance [voxels of the velocity]
Float4 downstream(const Scene& scene, Float4 position, float distance)
{
    const auto moved = [&](Float4 slope, float by) {
        constexpr float kStill = 1e-6f;
        return position + slope * (by / std::max(pathline::length(slope * scene.spaces.scale()), kStill));
    };
    const Float4 slope = scene.field.sample(position, 0, Float4{0, 0, 0, 0});
    return moved(scene.field.sample(moved(slope, 0.5f * distance), 0, slope), distance);
}

/// A unit vector perpendicular to the velocity. @param turn angle about it, 0 to 1 for a full turn
Float4 perpendicular(Float4 velocity, float turn)
{
    const Float4 axis = velocity / pathline::length(velocity);
    const auto cross = [](Float4 a, Float4 b) {
        return Float4{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0], 0};
    };
    const Float4 helper = std::abs(axis[0]) < 0.6f ? Float4{1, 0, 0, 0} : Float4{0, 1, 0, 0};
    Float4 first = cross(axis, helper);
    first /= pathline::length(first);
    const float angle = 2 * std::numbers::pi_v<float> * turn;
    return first * std::cos(angle) + cross(axis, first) * std::sin(angle);
}

void addSpatial(const Scene& scene, const Point& point, BlockSums& sums)
{
    const auto add = [&](std::vector<Correlation> Correlations::*direction, std::size_t lag, Float4 position) {
        const auto there = scene.texture.sample(position);
        if (!there.inside) return false;
        (sums.raw.*direction)[lag].add(point.here.raw, there.raw);
        (sums.smoothed.*direction)[lag].add(point.here.smoothed, there.smoothed);
        return true;
    };
    Float4 position = point.position;
    double before = 0;
    for (std::size_t lag = 0; lag < scene.lags.size(); ++lag) {
        position = downstream(scene, position, float(scene.lags[lag] - before));
        if (!add(&Correlations::along, lag, position)) break;
        before = scene.lags[lag];
    }
    const Float4 direction = perpendicular(point.velocity * scene.spaces.scale(), point.turn) / scene.spaces.scale();
    for (std::size_t lag = 0; lag < scene.lags.size(); ++lag) {
        if (!add(&Correlations::across, lag, point.position + direction * float(scene.lags[lag]))) break;
    }
}

VDBLIC_KERNEL void measureBlock(const Scene& scene, std::size_t block, BlockSums& sums)
{
    std::vector<Point> points;
    const std::size_t first = block * kBlockPoints;
    for (std::size_t i = first; i < std::min(first + kBlockPoints, std::size_t(scene.params.samples)); ++i) {
        paging::breathe(paging::kPointBytes);
        if (const auto point = pointOf(scene, i)) points.push_back(*point);
    }
    for (const Point& point : points) {
        paging::breathe(paging::kPointBytes);
        addSpatial(scene, point, sums);
    }
    if (scene.next) addTemporal(scene, points, sums);
}

/// The first lag at which an autocorrelation falls under 1/e, interpolated linearly between lags.
double lengthOf(const std::vector<double>& autocorrelation, const std::vector<double>& lags)
{
    constexpr double kThreshold = 1 / std::numbers::e;
    double before = 1, lagBefore = 0;
    for (std::size_t lag = 0; lag < lags.size(); ++lag) {
        const double value = autocorrelation[lag];
        if (std::isnan(value)) return kNone;
        if (value < kThreshold) return lagBefore + (before - kThreshold) / (before - value) * (lags[lag] - lagBefore);
        before = value;
        lagBefore = lags[lag];
    }
    return kLongestLag;
}

std::vector<double> valuesByLag(const std::vector<Correlation>& correlations)
{
    std::vector<double> values;
    values.reserve(correlations.size());
    for (const Correlation& correlation : correlations)
        values.push_back(correlation.value());
    return values;
}

CoherenceFigures figuresOf(const Correlations& sums, const Contrast& contrast, const std::vector<double>& lags)
{
    CoherenceFigures figures{};
    figures.temporal = sums.temporal.value();
    figures.samePlace = sums.samePlace.value();
    figures.gain = figures.temporal - figures.samePlace;
    figures.along = valuesByLag(sums.along);
    figures.across = valuesByLag(sums.across);
    figures.alongLength = lengthOf(figures.along, lags);
    figures.acrossLength = lengthOf(figures.across, lags);
    figures.lengthRatio = figures.alongLength / figures.acrossLength;
    figures.deviation = contrast.deviation;
    figures.saturated = contrast.saturated;
    return figures;
}

} // namespace

std::vector<double> coherenceLags(const std::array<int, 3>& factors)
{
    constexpr int kFineLags = 32;
    constexpr double kCoarse = 0.5;
    const int finest = std::max({factors[0], factors[1], factors[2]});
    std::vector<double> lags;
    for (int lag = 1; lag <= kFineLags; ++lag)
        lags.push_back(kCoarse * lag / finest);
    for (int lag = kFineLags / finest + 1; kCoarse * lag <= kLongestLag; ++lag)
        lags.push_back(kCoarse * lag);
    return lags;
}

FrameCoherence measureCoherence(const SmoothedTexture& texture, const SmoothedTexture* next, const VelocityField& field,
                                const CoherenceParams& params, std::int64_t frame)
{
    params.validate();
    const Domain& domain = texture.domain();
    const Refinement& refinement = field.frameDomain().refinement;
    const Scene scene{
        texture, next, field, params, coherenceLags(refinement.factors), {domain, frame}, IndexSpaces(refinement)};

    BlockSums all(scene.lags.size());
    if (domain.voxelCount() > 0) {
        std::vector<BlockSums> blocks((std::size_t(params.samples) + kBlockPoints - 1) / kBlockPoints, all);
        tbb::parallel_for(std::size_t(0), blocks.size(),
                          [&](std::size_t block) { measureBlock(scene, block, blocks[block]); });
        for (const BlockSums& block : blocks) {
            all.raw.add(block.raw);
            all.smoothed.add(block.smoothed);
        }
    }
    FrameCoherence result;
    result.frame = frame;
    result.points = all.raw.along[0].count();
    result.temporalPoints = all.raw.temporal.count();
    result.raw = figuresOf(all.raw, texture.rawContrast(), scene.lags);
    result.smoothed = figuresOf(all.smoothed, texture.smoothedContrast(), scene.lags);
    result.byDisplacement = measureCleanness(texture, next, field, params, frame);
    return result;
}

} // namespace vdblic
