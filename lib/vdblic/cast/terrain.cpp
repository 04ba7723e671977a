#include "vdblic/cast/terrain.h"

#include "vdblic/core/memory.h"

#include <openvdb/tools/SignedFloodFill.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <optional>
#include <vector>

namespace vdblic {
namespace {

/// Numbers of a rectangle of columns, constant beyond its sides.
template<typename T>
class Columns {
  public:
    Columns(int width, int depth) : mWidth(width), mDepth(depth), mValues(std::size_t(width) * std::size_t(depth)) {}

    [[nodiscard]] int width() const { return mWidth; }
    [[nodiscard]] int depth() const { return mDepth; }
    [[nodiscard]] T& at(int x, int y)
    {
        return mValues[std::size_t(std::clamp(x, 0, mWidth - 1)) * std::size_t(mDepth) +
                       std::size_t(std::clamp(y, 0, mDepth - 1))];
    }
    [[nodiscard]] const T& at(int x, int y) const { return const_cast<Columns*>(this)->at(x, y); }

  private:
    int mWidth, mDepth;
    std::vector<T> mValues;
};

/// The heights of columns that stand on the bottom of a box; nullopt if there are holes above others' tops.
std::optional<Columns<int>> heightsOf(const openvdb::MaskTree& rest, const openvdb::CoordBBox& box)
{
    const openvdb::Coord size = box.dim();
    Columns<int> heights(size.x(), size.y()), tops(size.x(), size.y());
    for (auto value = rest.cbeginValueOn(); value; ++value) {
        openvdb::CoordBBox part;
        value.getBoundingBox(part);
        part.translate(-box.min());
        for (int x = part.min().x(); x <= part.max().x(); ++x) {
            for (int y = part.min().y(); y <= part.max().y(); ++y) {
                heights.at(x, y) += part.dim().z();
                tops.at(x, y) = std::max(tops.at(x, y), part.max().z() + 1);
            }
        }
    }
    for (int x = 0; x < size.x(); ++x) {
        for (int y = 0; y < size.y(); ++y)
            if (heights.at(x, y) != tops.at(x, y)) return std::nullopt;
    }
    return heights;
}

/// Where heights change.
template<typename Visit>
void forSteps(const Columns<int>& heights, const Visit& visit)
{
    for (int x = 0; x < heights.width(); ++x) {
        for (int y = 0; y < heights.depth(); ++y) {
            const int height = heights.at(x, y);
            if (heights.at(x + 1, y) != height) visit(0, x + 1, std::abs(heights.at(x + 1, y) - height));
            if (heights.at(x, y + 1) != height) visit(1, y + 1, std::abs(heights.at(x, y + 1) - height));
        }
    }
}

/// The edge of the data's voxels, in voxels of the domain: all steps are at its multiples.
std::array<int, 3> stepsOf(const Columns<int>& heights, const openvdb::CoordBBox& box)
{
    const openvdb::Coord size = box.dim();
    std::array<int, 3> result{size.x(), size.y(), 0};
    for (int axis = 0; axis < 2; ++axis)
        result[std::size_t(axis)] = std::gcd(result[std::size_t(axis)], box.min()[axis]);
    forSteps(heights, [&](int axis, int place, int step) {
        result[std::size_t(axis)] = std::gcd(result[std::size_t(axis)], place);
        result[2] = std::gcd(result[2], step);
    });
    return result;
}

/// Whether most steps are small beside the range of heights, as on a slope: a wall is one step.
bool isSlope(const Columns<int>& heights)
{
    constexpr int kLeastSteps = 3; // from the lowest column to the highest
    constexpr double kLeastShare = 0.75;
    int lowest = heights.at(0, 0), highest = lowest;
    for (int x = 0; x < heights.width(); ++x) {
        for (int y = 0; y < heights.depth(); ++y) {
            lowest = std::min(lowest, heights.at(x, y));
            highest = std::max(highest, heights.at(x, y));
        }
    }
    std::size_t all = 0, small = 0;
    forSteps(heights, [&](int, int, int step) {
        ++all;
        small += kLeastSteps * step <= highest - lowest ? 1 : 0;
    });
    return all > 0 && double(small) >= kLeastShare * double(all);
}

/// Weights of the four next points in a uniform cubic B-spline. @param t from the second to the third, 0 to 1
std::array<double, 4> splineWeights(double t)
{
    const double rest = 1 - t;
    return {rest * rest * rest / 6, (4 - 6 * t * t + 3 * t * t * t) / 6,
            (4 - 6 * rest * rest + 3 * rest * rest * rest) / 6, t * t * t / 6};
}

/// The height of the surface over a column of the domain, which may be beside it.
double smoothHeight(const Columns<int>& data, int x, int y, const std::array<int, 3>& unit)
{
    const double u = (x + 0.5) / unit[0] - 0.5, v = (y + 0.5) / unit[1] - 0.5;
    const int left = int(std::floor(u)), near = int(std::floor(v));
    const std::array<double, 4> alongX = splineWeights(u - left), alongY = splineWeights(v - near);
    double height = 0;
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j)
            height += alongX[std::size_t(i)] * alongY[std::size_t(j)] * data.at(left + i - 1, near + j - 1);
    }
    return height;
}

} // namespace

openvdb::FloatGrid::Ptr terrainOf(const openvdb::MaskTree& rest, const openvdb::CoordBBox& box, int band)
{
    if (rest.empty()) return nullptr;
    const std::optional<Columns<int>> heights = heightsOf(rest, box);
    if (!heights || !isSlope(*heights)) return nullptr;
    const std::array<int, 3> unit = stepsOf(*heights, box);
    checkVoxels(std::uint64_t(heights->width()) * std::uint64_t(heights->depth()) * std::uint64_t(4 * band));

    Columns<int> data(heights->width() / unit[0], heights->depth() / unit[1]);
    for (int i = 0; i < data.width(); ++i) {
        for (int j = 0; j < data.depth(); ++j)
            data.at(i, j) = heights->at(i * unit[0], j * unit[1]);
    }
    const auto height = [&](int x, int y) { return smoothHeight(data, x, y, unit); };

    auto result = openvdb::FloatGrid::create(float(band));
    auto values = result->getUnsafeAccessor(); // no node is removed meanwhile
    const int plate = std::max(unit[2], 2);    // voxels: a thinner one could be missed
    for (int x = -band; x < heights->width() + band; ++x) {
        for (int y = -band; y < heights->depth() + band; ++y) {
            // From the box's bottom, in voxels; their centres are half of one above.
            const double top = height(x, y);
            const double slope =
                std::hypot(1, (height(x + 1, y) - height(x - 1, y)) / 2, (height(x, y + 1) - height(x, y - 1)) / 2);
            const double aside = std::max({-0.5 - x, x + 0.5 - heights->width(), -0.5 - y, y + 0.5 - heights->depth()});
            const int first = -plate - band, last = int(std::ceil(top + band * slope));
            const int belowSurface = int(std::floor(top - band * slope)) - 1;
            for (int z = first; z <= last; ++z) {
                // Between plate and surface, only voxels near the sides need a distance.
                if (z == -plate + band && aside < -band) z = std::max(z, belowSurface);
                const double distance = std::max({(z + 0.5 - top) / slope, -plate - (z + 0.5), aside});
                if (std::abs(distance) < band) values.setValue(box.min() + openvdb::Coord(x, y, z), float(distance));
            }
        }
    }
    openvdb::tools::signedFloodFill(result->tree());
    return result;
}

} // namespace vdblic
