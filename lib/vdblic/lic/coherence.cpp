#include "vdblic/lic/coherence.h"

#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/noise.h"
#include "vdblic/lic/pathline.h"
#include "vdblic/lic/smoothed_texture.h"

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

/// Sums for Pearson's correlation, taken about the middle of a texture's range to limit cancellation.
class Correlation {
  public:
    void add(float a, float b)
    {
        const double x = double(a) - 0.5, y = double(b) - 0.5;
        mSums[0] += x;
        mSums[1] += y;
        mSums[2] += x * x;
        mSums[3] += y * y;
        mSums[4] += x * y;
        ++mCount;
    }
    void add(const Correlation& other)
    {
        for (std::size_t i = 0; i < mSums.size(); ++i)
            mSums[i] += other.mSums[i];
        mCount += other.mCount;
    }
    [[nodiscard]] std::size_t count() const { return mCount; }
    [[nodiscard]] double value() const
    {
        const double n = double(mCount), x = mSums[0] / n, y = mSums[1] / n;
        const double xx = mSums[2] / n - x * x, yy = mSums[3] / n - y * y;
        constexpr double kLeastVariance = 1e-12; // below: rounding of a constant
        if (!(xx > kLeastVariance && yy > kLeastVariance)) return kNone;
        return (mSums[4] / n - x * y) / std::sqrt(xx * yy);
    }

  private:
    std::array<double, 5> mSums{};
    std::size_t mCount = 0;
};

/// The correlations of a texture, raw or smoothed.
struct Correlations {
    Correlation temporal, samePlace;
    std::array<Correlation, kLagCount> along, across;

    void add(const Correlations& other)
    {
        temporal.add(other.temporal);
        samePlace.add(other.samePlace);
        for (std::size_t lag = 0; lag < kLagCount; ++lag) {
            along[lag].add(other.along[lag]);
            across[lag].add(other.across[lag]);
        }
    }
};

struct BlockSums {
    Correlations raw, smoothed;
};

/// A point at which the texture is sampled.
struct Point {
    Float4 position, velocity; ///< index space, voxels per step
    SmoothedTexture::Sample here;
    float turn; ///< selects the perpendicular direction, 0 to 1
};

struct Scene {
    const SmoothedTexture& texture;
    const SmoothedTexture* next;
    const VelocityField& field;
    const CoherenceParams& params;
    std::vector<std::size_t> voxelsBefore; ///< each leaf: voxels of the leaves before it; last: all voxels
    std::uint64_t key;                     ///< added to a point's number before hashing
};

/// A number in [0, 1) of 24 random bits: exact in single precision.
float unit(std::uint64_t bits)
{
    return float(bits >> 40) * 0x1p-24f;
}

Float4 positionOf(const Scene& scene, std::uint64_t hash)
{
    const auto rank = std::size_t((hash >> 32) * scene.voxelsBefore.back() >> 32);
    const auto after = std::upper_bound(scene.voxelsBefore.begin(), scene.voxelsBefore.end(), rank);
    const auto leaf = std::size_t(after - scene.voxelsBefore.begin()) - 1;
    auto voxel = scene.texture.domain().mask(leaf).beginOn();
    for (std::size_t skip = rank - scene.voxelsBefore[leaf]; skip > 0; --skip)
        ++voxel;
    const openvdb::Coord origin = scene.texture.domain().origin(leaf);
    const LeafVoxel inLeaf = LeafVoxel::at(voxel.pos());
    const Float4 centre = {float(origin[0] + inLeaf.x), float(origin[1] + inLeaf.y), float(origin[2] + inLeaf.z), 0};
    const std::uint64_t x = mixBits(hash), y = mixBits(x), z = mixBits(y);
    return centre + Float4{unit(x), unit(y), unit(z), 0.5f} - 0.5f;
}

/// The point with a number, if it counts.
std::optional<Point> pointOf(const Scene& scene, std::uint64_t number)
{
    const std::uint64_t hash = mixBits(scene.key + number);
    Point point;
    point.position = positionOf(scene, hash);
    point.turn = unit(mixBits(~hash));
    point.here = scene.texture.sample(point.position);
    if (!point.here.inside || !scene.field.domain().contains(point.position)) return std::nullopt;
    point.velocity = scene.field.sample(point.position, 0, Float4{0, 0, 0, 0});
    if (!(pathline::length(point.velocity) >= scene.params.leastMotion)) return std::nullopt;
    return point;
}

/// Correlate with the successor, at the same position and at the end of the pathline.
void addTemporal(const Scene& scene, const std::vector<Point>& points, BlockSums& sums)
{
    PathBatch batch;
    const LeafWindow anywhere;
    for (std::size_t first = 0; first < points.size(); first += kLanes) {
        const int count = int(std::min<std::size_t>(kLanes, points.size() - first));
        batch.lanes = (1u << count) - 1;
        for (int lane = 0; lane < count; ++lane) {
            batch.position.setLane(lane, points[first + std::size_t(lane)].position);
            batch.slope.setLane(lane, points[first + std::size_t(lane)].velocity);
        }
        advancePaths(scene.field, anywhere, scene.params.pathline, batch);
        for (int lane = 0; lane < count; ++lane) {
            const Point& point = points[first + std::size_t(lane)];
            const auto there = scene.next->sample(batch.position.lane(lane)), same = scene.next->sample(point.position);
            if (!(batch.arrived >> lane & 1) || !there.inside || !same.inside) continue;
            sums.raw.temporal.add(point.here.raw, there.raw);
            sums.raw.samePlace.add(point.here.raw, same.raw);
            sums.smoothed.temporal.add(point.here.smoothed, there.smoothed);
            sums.smoothed.samePlace.add(point.here.smoothed, same.smoothed);
        }
    }
}

/// The position one lag further along the streamline, by the midpoint rule; over half a voxel its error is far below a
/// voxel.
Float4 downstream(const VelocityField& field, Float4 position)
{
    constexpr float kStill = 1e-6f;
    const Float4 slope = field.sample(position, 0, Float4{0, 0, 0, 0});
    const Float4 middle = position + slope * (0.5f * kLagSpacing / std::max(pathline::length(slope), kStill));
    const Float4 slope2 = field.sample(middle, 0, slope);
    return position + slope2 * (kLagSpacing / std::max(pathline::length(slope2), kStill));
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
    const auto add = [&](std::array<Correlation, kLagCount> Correlations::*direction, int lag, Float4 position) {
        const auto there = scene.texture.sample(position);
        if (!there.inside) return false;
        (sums.raw.*direction)[std::size_t(lag)].add(point.here.raw, there.raw);
        (sums.smoothed.*direction)[std::size_t(lag)].add(point.here.smoothed, there.smoothed);
        return true;
    };
    Float4 position = point.position;
    for (int lag = 0; lag < kLagCount; ++lag) {
        position = downstream(scene.field, position);
        if (!add(&Correlations::along, lag, position)) break;
    }
    const Float4 step = perpendicular(point.velocity, point.turn) * kLagSpacing;
    for (int lag = 0; lag < kLagCount; ++lag) {
        if (!add(&Correlations::across, lag, point.position + step * float(lag + 1))) break;
    }
}

VDBLIC_KERNEL void measureBlock(const Scene& scene, std::size_t block, BlockSums& sums)
{
    std::vector<Point> points;
    const std::size_t first = block * kBlockPoints;
    for (std::size_t i = first; i < std::min(first + kBlockPoints, std::size_t(scene.params.samples)); ++i) {
        if (const auto point = pointOf(scene, i)) points.push_back(*point);
    }
    for (const Point& point : points)
        addSpatial(scene, point, sums);
    if (scene.next) addTemporal(scene, points, sums);
}

/// The first lag at which an autocorrelation falls under 1/e, interpolated linearly between lags [voxels].
double lengthOf(const std::array<double, kLagCount>& autocorrelation)
{
    constexpr double kThreshold = 1 / std::numbers::e;
    double before = 1;
    for (std::size_t lag = 0; lag < kLagCount; ++lag) {
        const double value = autocorrelation[lag];
        if (std::isnan(value)) return kNone;
        if (value < kThreshold) return (double(lag) + (before - kThreshold) / (before - value)) * double(kLagSpacing);
        before = value;
    }
    return kLongestLag;
}

CoherenceFigures figuresOf(const Correlations& sums, const Contrast& contrast)
{
    CoherenceFigures figures{};
    figures.temporal = sums.temporal.value();
    figures.samePlace = sums.samePlace.value();
    figures.gain = figures.temporal - figures.samePlace;
    for (std::size_t lag = 0; lag < kLagCount; ++lag) {
        figures.along[lag] = sums.along[lag].value();
        figures.across[lag] = sums.across[lag].value();
    }
    figures.alongLength = lengthOf(figures.along);
    figures.acrossLength = lengthOf(figures.across);
    figures.lengthRatio = figures.alongLength / figures.acrossLength;
    figures.deviation = contrast.deviation;
    figures.saturated = contrast.saturated;
    return figures;
}

} // namespace

FrameCoherence measureCoherence(const SmoothedTexture& texture, const SmoothedTexture* next, const VelocityField& field,
                                const CoherenceParams& params, std::int64_t frame)
{
    params.validate();
    const Domain& domain = texture.domain();
    // The factor keeps frame k + 1 from using the points of frame k shifted by one.
    Scene scene{texture, next, field, params, {0}, mixBits(std::uint64_t(frame) * 0x9e3779b97f4a7c15u + 1)};
    scene.voxelsBefore.reserve(domain.leafCount() + 1);
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf)
        scene.voxelsBefore.push_back(scene.voxelsBefore.back() + domain.mask(leaf).countOn());

    BlockSums all;
    if (domain.voxelCount() > 0) {
        std::vector<BlockSums> blocks((std::size_t(params.samples) + kBlockPoints - 1) / kBlockPoints);
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
    result.raw = figuresOf(all.raw, texture.rawContrast());
    result.smoothed = figuresOf(all.smoothed, texture.smoothedContrast());
    return result;
}

} // namespace vdblic
