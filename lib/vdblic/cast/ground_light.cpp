#include "vdblic/cast/ground_light.h"

#include "vdblic/cast/coarse_cells.h"
#include "vdblic/cast/extinction_grid.h"
#include "vdblic/cast/lanes.h"
#include "vdblic/cast/solid.h"
#include "vdblic/volume/placed_box.h"

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <openvdb/tools/Interpolation.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

namespace vdblic {
namespace {

constexpr int kMostAcross = 192; // points of the lattice under the domain's longer side
constexpr int kKeyDirections = 16, kOpenDirections = 32;
constexpr double kKeyRadius = 0.06; // of the key light's disc, at distance 1
constexpr double kReach = 1 / 4.0;  // of occlusion, in mean edges of the domain
constexpr double kFarthest = 2.5;   // reaches beyond which matter does not occlude
constexpr float kKeyShare = 0.6f;   // of the light of an open ground
constexpr std::size_t kMostSolidCells = 1 << 20;
constexpr int kMostSkipped = 16; // steps of a ray through empty cells

/// Directions of length 1 in world space whose projections are spread evenly over a disc (Vogel's spiral 1979).
/// @param axis of the disc, of length 1
/// @param radius of a disc at distance 1; nullopt: a hemisphere with a density of Lambert's cosine
std::vector<glm::dvec3> directionsAround(const glm::dvec3& axis, std::optional<double> radius, int count)
{
    const glm::dvec3 other = std::abs(axis.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 right = glm::normalize(glm::cross(axis, other)), up = glm::cross(axis, right);
    std::vector<glm::dvec3> result;
    result.reserve(std::size_t(count));
    for (int i = 0; i < count; ++i) {
        const double square = (i + 0.5) / count, angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
        const double along = radius ? 1 : std::sqrt(1 - square);
        const glm::dvec2 across = radius.value_or(1) * std::sqrt(square) * glm::dvec2(std::cos(angle), std::sin(angle));
        result.push_back(glm::normalize(axis * along + right * across.x + up * across.y));
    }
    return result;
}

/// How many steps through empty cells may be left out: an extinction of 0 changes no light. By cell, of a ray between
/// its centre and those above: 0 if values interpolated there can differ from 0. Steps are a cell or shorter.
std::vector<std::uint8_t> emptySteps(std::span<const float> values, const openvdb::Coord& dim)
{
    constexpr std::size_t kWord = sizeof(std::uint64_t); // cells at a time
    const std::size_t strides[] = {1, std::size_t(dim[2]), std::size_t(dim[1]) * std::size_t(dim[2])};
    const std::size_t before = strides[2], words = values.size() / kWord + 1;
    std::vector<std::uint8_t> empty(before + words * kWord + before, 1), next(empty), result(words * kWord);
    std::transform(values.begin(), values.end(), empty.begin() + std::ptrdiff_t(before),
                   [](float value) { return value == 0; });
    const auto load = [](const std::uint8_t* from) {
        std::uint64_t word = 0;
        std::memcpy(&word, from, kWord);
        return word;
    };
    for (int distance = 1; distance <= kMostSkipped + 1; ++distance) {
        for (const std::size_t stride : strides) { // also past the ends of rows, which leaves out fewer steps
            for (std::size_t i = before; i < before + words * kWord; i += kWord) {
                const std::uint8_t* const at = empty.data() + i;
                const std::uint64_t all = load(at) & load(at - stride) & load(at + stride);
                std::memcpy(&next[i], &all, kWord);
            }
            empty.swap(next);
        }
        if (distance == 2) continue; // rounding may lead a step into one cell more
        for (std::size_t i = 0; i < words * kWord; i += kWord) {
            const std::uint64_t sums = load(&result[i]) + load(&empty[before + i]);
            std::memcpy(&result[i], &sums, kWord);
        }
    }
    return result;
}

/// An absorbing or opaque medium, on coarse cells of an index space.
struct Medium {
    const float* values;
    CoarseCells cells;
    std::vector<std::uint8_t> empty; // as emptySteps() has them
    glm::dvec3 low, high;            // bounds in index space
    glm::dmat4 toIndex;
    std::span<const ClipPlane> cuts;
    double step;   // index space
    bool isOpaque; // values are shares of cells that are filled, else extinctions
};

/// Eight points, as a medium's index space has them.
struct Points {
    struct OfCut {
        Float8 height; // above it, world; a vector of bare Float8 would not be aligned
    };
    Float8 from[3], low[3], high[3]; // positions, and the bounds relative to them
    std::vector<OfCut> cuts;

    Points(const Medium& medium, const std::array<glm::dvec3, kLanes>& points) : cuts(medium.cuts.size())
    {
        for (int lane = 0; lane < kLanes; ++lane) {
            const glm::dvec3& point = points[std::size_t(lane)];
            const glm::dvec3 begin(medium.toIndex * glm::dvec4(point, 1));
            for (int axis = 0; axis < 3; ++axis) {
                from[axis][lane] = float(begin[axis]);
                low[axis][lane] = float(medium.low[axis] - begin[axis]);
                high[axis][lane] = float(medium.high[axis] - begin[axis]);
            }
            for (std::size_t cut = 0; cut < cuts.size(); ++cut)
                cuts[cut].height[lane] = float(medium.cuts[cut].height(point));
        }
    }
};

/// Rays of light from a direction, through a medium.
struct LightWays {
    const Medium& medium;
    float unit[3], inverse[3];   // the direction in index space, of length 1, and huge for 0
    float farthest;              // length of the ways [voxels]
    float keep;                  // binary logarithm of the decay per voxel of distance
    std::vector<float> slopes{}; // growth of the height above each cut, per voxel

    /// @param reach distance over which the effect decays to 1/e; or infinite [world]
    LightWays(const Medium& through, const glm::dvec3& direction, double length, double reach) : medium(through)
    {
        constexpr double kTiny = 1e-12, kEndless = 1e12;
        const glm::dvec3 along = glm::dmat3(medium.toIndex) * direction;
        const double perWorld = glm::length(along);
        for (int axis = 0; axis < 3; ++axis) {
            const double part = along[axis] / perWorld;
            unit[axis] = float(part);
            inverse[axis] = float(std::abs(part) > kTiny ? 1 / part : 1 / kTiny);
        }
        farthest = float(std::min(length * perWorld, kEndless));
        keep = float(-std::numbers::log2e / (reach * perWorld));
        for (const ClipPlane& cut : medium.cuts)
            slopes.push_back(float(glm::dot(direction, cut.normal) / perWorld));
    }
};

/// The steps that all of the lanes may leave out. @param lanes that still move
VDBLIC_INLINE int leastEmpty(const std::vector<std::uint8_t>& empty, Unsigned8 cells, Int8 lanes)
{
    int least = kMostSkipped;
    for (int lane = 0; lane < kLanes; ++lane)
        if (lanes[lane] != 0) least = std::min(least, int(empty[cells[lane]]));
    return least;
}

/// Multiply transmittances to points by the medium's. @param left of each point
VDBLIC_KERNEL
void trace(const LightWays& ways, const Points& points, Float8& left)
{
    const Medium& medium = ways.medium;
    Float8 enter{}, leave = left > 0 ? broadcast8(ways.farthest) : Float8{}; // distances in voxels
    for (int axis = 0; axis < 3; ++axis) {
        const Float8 low = points.low[axis] * ways.inverse[axis], high = points.high[axis] * ways.inverse[axis];
        const Float8 first = low < high ? low : high, last = low < high ? high : low;
        enter = first > enter ? first : enter;
        leave = last < leave ? last : leave;
    }
    for (std::size_t cut = 0; cut < ways.slopes.size(); ++cut) {
        const float slope = ways.slopes[cut];
        const Float8 height = points.cuts[cut].height, crossing = -height / slope;
        if (slope > 0) enter = crossing > enter ? crossing : enter;
        if (slope < 0) leave = crossing < leave ? crossing : leave;
        if (slope == 0) leave = height < 0 ? Float8{} : leave;
    }
    if (!anyOf(enter < leave)) return;

    // The last step of a ray is shorter.
    const auto step = float(medium.step);
    Float8 sum{}, most{}, steps = (leave - enter) / step;
    for (int done = 0, skipped = 0; anyOf(float(done) < steps); done += std::max(skipped, 1)) {
        const Float8 at = enter + float(done) * step, rest = leave - at,
                     length = positive(rest < step ? rest : broadcast8(step));
        const Float8 middle = at + 0.5f * length;
        const Float8 position[] = {points.from[0] + ways.unit[0] * middle, points.from[1] + ways.unit[1] * middle,
                                   points.from[2] + ways.unit[2] * middle};
        const CoarseCells::Places places = medium.cells.places(position);
        skipped = leastEmpty(medium.empty, places.low, float(done) < steps);
        if (skipped > 0) continue;
        const Float8 share = medium.cells.at(medium.values, places);
        const Float8 value = share * powerOfTwo(ways.keep * middle);
        sum += value * length;
        const Float8 inside = length > 0 ? value : Float8{};
        most = inside > most ? inside : most;
        if (medium.isOpaque) steps = share < 1 ? steps : Float8{}; // farther matter counts less
    }
    left *= medium.isOpaque ? 1 - clamped(most) : powerOfTwo(-std::numbers::log2e_v<float> * sum);
}

Medium mediumOf(const ShadowCasters& casters)
{
    const ExtinctionGrid& grid = casters.visible;
    const openvdb::Coord end = grid.origin() + openvdb::Coord(grid.dim()[0] * grid.cell(), grid.dim()[1] * grid.cell(),
                                                              grid.dim()[2] * grid.cell());
    return {grid.values().data(),
            CoarseCells(grid.origin(), grid.dim(), grid.cell()),
            emptySteps(grid.values(), grid.dim()),
            glm::dvec3(grid.origin()[0], grid.origin()[1], grid.origin()[2]) - 0.5,
            glm::dvec3(end[0], end[1], end[2]) - 0.5,
            casters.box.worldToIndex(),
            casters.cuts,
            double(grid.cell()),
            false};
}

/// How much of each cell is inside a solid, on cells around it with an empty one at each side.
struct SolidCells {
    openvdb::Coord origin, dim;
    int cell = 1;
    std::vector<float> shares;

    explicit SolidCells(const Solid& solid)
    {
        openvdb::CoordBBox box = boundsOf(solid);
        if (box.empty()) box = {openvdb::Coord(0), openvdb::Coord(0)};
        const auto cells = [&] {
            origin = box.min().offsetBy(-cell);
            for (int axis = 0; axis < 3; ++axis)
                dim[axis] = (box.dim()[axis] - 1) / cell + 3;
            return double(dim[0]) * dim[1] * dim[2];
        };
        while (cells() > double(kMostSolidCells))
            cell *= 2;
        shares.resize(std::size_t(dim[0]) * std::size_t(dim[1]) * std::size_t(dim[2]));
        tbb::parallel_for(0, dim[0], [&](int x) {
            const auto values = solid.levelSet->getConstAccessor();
            std::size_t at = std::size_t(x) * std::size_t(dim[1]) * std::size_t(dim[2]);
            for (int y = 0; y < dim[1]; ++y) {
                for (int z = 0; z < dim[2]; ++z) {
                    const glm::dvec3 middle = glm::dvec3(x, y, z) * double(cell) + 0.5 * (cell - 1);
                    const openvdb::Vec3d place(middle.x + origin[0], middle.y + origin[1], middle.z + origin[2]);
                    const float distance = openvdb::tools::BoxSampler::sample(values, place);
                    shares[at++] = std::clamp(0.5f - distance / float(cell), 0.0f, 1.0f);
                }
            }
        });
    }
};

Medium mediumOf(const SolidCells& cells, const ShadowCasters& casters)
{
    const glm::dvec3 low(cells.origin[0], cells.origin[1], cells.origin[2]);
    const glm::dvec3 dim(cells.dim[0], cells.dim[1], cells.dim[2]);
    return {cells.shares.data(),
            CoarseCells(cells.origin, cells.dim, cells.cell),
            emptySteps(cells.shares, cells.dim),
            low - 0.5,
            low + dim * double(cells.cell) - 0.5,
            casters.solid->worldToIndex,
            {},
            double(cells.cell),
            true};
}

} // namespace

GroundLight::GroundLight(const GroundPlane& plane, const ShadowCasters& casters, const glm::dvec3& towardsLight)
{
    std::vector<Medium> media;
    std::optional<SolidCells> solidCells;
    if (casters.solid) {
        solidCells.emplace(*casters.solid);
        media.push_back(mediumOf(*solidCells, casters));
    }
    const Medium& volume = media.emplace_back(mediumOf(casters));
    const double side = std::max(plane.half.x, plane.half.y) * 2;
    const double cellEdge = volume.step / glm::length(glm::dmat3(volume.toIndex) * plane.axes[0]);
    const double spacing = std::max(side / kMostAcross, cellEdge);
    mPerSpacing = 1 / spacing;
    mLow = plane.middle - plane.half - plane.fade;
    mSize = glm::ivec2(glm::ceil((plane.half + plane.fade) * 2.0 * mPerSpacing)) + 1;
    mLit.assign(std::size_t(mSize.x) * std::size_t(mSize.y), 1);

    const glm::dvec3 key = glm::normalize(towardsLight);
    const double never = std::numeric_limits<double>::infinity();
    double edges = 1;
    const glm::dvec3 extent = volume.high - volume.low;
    for (int axis = 0; axis < 3; ++axis)
        edges *= extent[axis] * glm::length(glm::dmat3(casters.box.indexToWorld())[axis]);
    const double reach = kReach * std::cbrt(edges);
    struct Light {
        std::vector<LightWays> through; // the media, one behind the other
        float share;                    // of the open ground's light
    };
    std::vector<Light> lights;
    const auto add = [&](const std::vector<glm::dvec3>& directions, double length, double effect, float share) {
        for (const glm::dvec3& direction : directions) {
            Light& light = lights.emplace_back(Light{{}, share / float(directions.size())});
            for (const Medium& medium : media)
                light.through.emplace_back(medium, direction, length, effect);
        }
    };
    if (glm::dot(key, plane.normal) > 0)
        add(directionsAround(key, kKeyRadius, kKeyDirections), never, never, kKeyShare);
    add(directionsAround(plane.normal, std::nullopt, kOpenDirections), kFarthest * reach, reach, 1 - kKeyShare);

    tbb::parallel_for(0, mSize.y, [&](int row) {
        for (int first = 0; first < mSize.x; first += kLanes) {
            std::array<glm::dvec3, kLanes> place;
            Float8 seen{};
            for (int lane = 0; lane < kLanes; ++lane) {
                const glm::dvec2 at = mLow + glm::dvec2(first + lane, row) * spacing;
                place[std::size_t(lane)] = plane.at(at);
                seen[lane] = first + lane < mSize.x && plane.alpha(at) > 0 ? 1 : 0;
            }
            if (!anyOf(seen > 0)) continue;
            std::vector<Points> points;
            points.reserve(media.size());
            for (const Medium& medium : media)
                points.emplace_back(medium, place);
            Float8 taken{};
            for (const Light& light : lights) {
                Float8 left = seen;
                for (std::size_t i = 0; i < media.size(); ++i)
                    trace(light.through[i], points[i], left);
                taken += light.share * (seen - left);
            }
            const int count = std::min(kLanes, mSize.x - first);
            float* const lit = mLit.data() + std::size_t(row) * std::size_t(mSize.x) + std::size_t(first);
            for (int lane = 0; lane < count; ++lane)
                lit[lane] = 1 - taken[lane];
        }
    });
}

float GroundLight::at(const glm::dvec2& place) const
{
    const glm::dvec2 most = glm::dvec2(mSize - 1);
    const glm::dvec2 inside = glm::clamp((place - mLow) * mPerSpacing, glm::dvec2(0), most);
    const glm::ivec2 low = glm::min(glm::ivec2(inside), mSize - 2);
    const glm::vec2 fraction(inside - glm::dvec2(low));
    const float* const first = mLit.data() + std::size_t(low.y) * std::size_t(mSize.x) + std::size_t(low.x);
    const float* const second = first + mSize.x;
    return glm::mix(glm::mix(first[0], first[1], fraction.x), glm::mix(second[0], second[1], fraction.x), fraction.y);
}

} // namespace vdblic
