#include "vdblic/cast/tubes.h"

#include "vdblic/camera/affine_transform.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/extent.h"

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

namespace vdblic {
namespace {

/// Voxels of the box along a voxel of the lines: as fine as the light's cells allow.
double finenessFor(const glm::dvec3& extent)
{
    constexpr double kMostCells = 1 << 20, kCell = 2;
    return std::max(std::floor(kCell * std::cbrt(kMostCells / (extent.x * extent.y * extent.z))), 1.0);
}

/// The voxels that points lie in.
struct Extent {
    glm::dvec3 low{0}, high{0};

    explicit Extent(const std::vector<openvdb::Vec3f>& points)
    {
        for (std::size_t i = 0; i < points.size(); ++i) {
            const glm::dvec3 at = glm::round(glm::dvec3(points[i][0], points[i][1], points[i][2]));
            low = i == 0 ? at : glm::min(low, at);
            high = i == 0 ? at : glm::max(high, at);
        }
    }
    [[nodiscard]] glm::dvec3 size() const { return high - low + 1.0; }
};

} // namespace

Tubes::Tubes(const Lines& lines, Values values, const openvdb::math::Transform& transform, const glm::dvec3& stretch,
             const std::function<bool(const openvdb::Coord&)>& isShown)
    : PlacedBox(glm::scale(glm::scale(glm::dmat4(1), stretch) * affineMatrix(transform, "the grid of lines"),
                           glm::dvec3(1 / finenessFor(Extent(lines.positions).size())))),
      mOpacities(lines.opacities), mValues(std::move(values))
{
    const auto isUsable = [](const std::vector<float>& of, std::uint32_t first) {
        return of.empty() || std::isfinite(of[first]) || std::isfinite(of[first + 1]);
    };
    for (const Lines::Line& line : lines.lines) {
        bool isBound = false; // the previous cone is there
        for (std::uint32_t i = line.begin; i + 1 < line.end; ++i) {
            const openvdb::Vec3f middle = (lines.positions[i] + lines.positions[i + 1]) * 0.5f;
            const bool usable = isUsable(mValues.driver, i) && isUsable(mValues.color, i);
            mUnusable += usable ? 0 : 1;
            const bool isThere = usable && lines.radii[i] + lines.radii[i + 1] > 0 &&
                                 isShown(openvdb::Coord::round(openvdb::Vec3d(middle)));
            if (isThere) {
                if (isBound) mCones.back().hasNext = true;
                mCones.push_back({i, line.id, isBound, false});
            }
            isBound = isThere;
        }
    }
    place(lines, std::cbrt(stretch.x * stretch.y * stretch.z));
}

/// Set the box and the points. @param perRadius by which the stretch makes radii longer
void Tubes::place(const Lines& lines, double perRadius)
{
    const Extent extent(lines.positions);
    const double fineness = finenessFor(extent.size());
    mLow = (extent.low - 0.5) * fineness;
    mHigh = (extent.high + 0.5) * fineness;
    mUnitsPerWorld = 1 / (voxelSize() * fineness);
    const glm::dvec3 centre(indexToWorld() * glm::dvec4((mLow + mHigh) / 2.0, 1));
    mWorldToTubes = glm::translate(glm::scale(glm::dmat4(1), glm::dvec3(mUnitsPerWorld)), -centre);
    const glm::dmat4 toTubes = glm::scale(mWorldToTubes * indexToWorld(), glm::dvec3(fineness));
    mPoints.resize(lines.pointCount());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mPoints.size()), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const openvdb::Vec3f& p = lines.positions[i];
            const glm::dvec3 at(toTubes * glm::dvec4(p[0], p[1], p[2], 1));
            const double radius = double(lines.radii[i]) * perRadius * mUnitsPerWorld;
            mPoints[i] = {float(at.x), float(at.y), float(at.z), float(radius)};
        }
    });
}

double Tubes::bytes() const
{
    constexpr double kTreePerCone = 110 + 2 * sizeof(Point); // measured, and the ends of the cones
    const double scalars = 1 + (mValues.driver.empty() ? 0 : 1) + (mValues.color.empty() ? 0 : 1);
    return double(mCones.size()) * (sizeof(Cone) + kTreePerCone) +
           double(mPoints.size()) * (sizeof(Point) + scalars * sizeof(float));
}

float Tubes::valueAt(const std::vector<float>& values, std::uint32_t first, float share)
{
    const float a = values[first], b = values[first + 1];
    if (std::isnan(a)) return b;
    return std::isnan(b) ? a : a + (b - a) * share;
}

double Tubes::length(std::uint32_t cone) const
{
    const Point* const ends = points(cone);
    const float way =
        glm::distance(glm::vec3(ends[0].x, ends[0].y, ends[0].z), glm::vec3(ends[1].x, ends[1].y, ends[1].z));
    return double(way + (mCones[cone].hasNext ? 0 : 2 * ends[1].radius));
}

VolumeSamples Tubes::samples() const
{
    constexpr double kMost = 200'000;
    double all = 0;
    for (std::uint32_t cone = 0; cone < mCones.size(); ++cone)
        all += length(cone);
    VolumeSamples samples;
    double next = 0.5; // place [spacings from the cone's first point]
    for (std::uint32_t cone = 0; all > 0 && cone < mCones.size(); ++cone) {
        const double places = length(cone) * kMost / all;
        while (next < places) {
            const std::uint32_t first = mCones[cone].first;
            const auto share = float(next / places);
            next += 1;
            samples.texture.push_back(valueAt(mOpacities, first, share));
            samples.driver.push_back(valueAt(mValues.driver, first, share));
            if (!mValues.color.empty()) samples.color.push_back(valueAt(mValues.color, first, share));
        }
        next -= places;
    }
    return samples;
}

double Tubes::crossings() const
{
    double shadow = 0;
    for (std::uint32_t cone = 0; cone < mCones.size(); ++cone) {
        const Point* const ends = points(cone);
        shadow += std::numbers::pi / 4 * length(cone) * double(ends[0].radius + ends[1].radius);
    }
    const auto edge = [&](int axis) {
        return glm::length(glm::dvec3(indexToWorld()[axis])) * (mHigh[axis] - mLow[axis]) * mUnitsPerWorld;
    };
    return shadow * 2 / (edge(0) * edge(1) + edge(1) * edge(2) + edge(2) * edge(0));
}

LeafRange Tubes::range() const
{
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    LeafRange range{kInfinity, -kInfinity, 1};
    for (const Cone& cone : mCones) {
        for (const float share : {0.0f, 1.0f}) {
            const float value = valueAt(mValues.driver, cone.first, share);
            range.lowDriver = std::min(range.lowDriver, value);
            range.highDriver = std::max(range.highDriver, value);
        }
    }
    return range;
}

} // namespace vdblic
