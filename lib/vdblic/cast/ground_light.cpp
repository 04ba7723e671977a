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
#include <limits>
#include <numbers>
#include <optional>
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

/// Eight directions in world space, each of length 1.
using Directions = std::array<glm::dvec3, kLanes>;

/// Directions whose projections are spread evenly over a disc (Vogel's spiral 1979).
/// @param axis of the disc, of length 1
/// @param radius of a disc at distance 1; nullopt: a hemisphere with a density of Lambert's cosine
std::vector<Directions> directionsAround(const glm::dvec3& axis, std::optional<double> radius, int count)
{
    const glm::dvec3 other = std::abs(axis.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 right = glm::normalize(glm::cross(axis, other)), up = glm::cross(axis, right);
    std::vector<Directions> result(std::size_t(count / kLanes));
    for (int i = 0; i < count; ++i) {
        const double square = (i + 0.5) / count, angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
        const double along = radius ? 1 : std::sqrt(1 - square);
        const glm::dvec2 across = radius.value_or(1) * std::sqrt(square) * glm::dvec2(std::cos(angle), std::sin(angle));
        result[std::size_t(i / kLanes)][std::size_t(i % kLanes)] =
            glm::normalize(axis * along + right * across.x + up * across.y);
    }
    return result;
}

/// An absorbing or opaque medium, on coarse cells of an index space.
struct Medium {
    const float* values;
    CoarseCells cells;
    glm::dvec3 low, high; // bounds in index space
    glm::dmat4 toIndex;
    std::span<const ClipPlane> cuts;
    double step;   // index space
    bool isOpaque; // values are shares of cells that are filled, else extinctions
};

/// Rays of light from eight directions to points, through a medium.
struct LightWays {
    struct Slope {
        Float8 perVoxel; // growth of the height above a cut; a vector of bare Float8 would not be aligned
    };
    const Medium& medium;
    Float8 unit[3], inverse[3]; // directions in index space, of length 1, and huge for 0
    Float8 farthest;            // length of the ways [voxels]
    Float8 keep;                // binary logarithm of the decay per voxel of distance
    std::vector<Slope> slopes;  // of the ways above the cuts

    /// @param reach distance over which the effect decays to 1/e; or infinite [world]
    LightWays(const Medium& through, const Directions& directions, double length, double reach);
};

LightWays::LightWays(const Medium& through, const Directions& directions, double length, double reach)
    : medium(through), slopes(through.cuts.size())
{
    constexpr double kTiny = 1e-12, kEndless = 1e12;
    const glm::dmat3 linear(medium.toIndex);
    for (int lane = 0; lane < kLanes; ++lane) {
        const glm::dvec3& direction = directions[std::size_t(lane)];
        const glm::dvec3 along = linear * direction;
        const double perWorld = glm::length(along);
        for (int axis = 0; axis < 3; ++axis) {
            const double part = along[axis] / perWorld;
            unit[axis][lane] = float(part);
            inverse[axis][lane] = float(std::abs(part) > kTiny ? 1 / part : 1 / kTiny);
        }
        farthest[lane] = float(std::min(length * perWorld, kEndless));
        keep[lane] = float(-std::numbers::log2e / (reach * perWorld));
        for (std::size_t cut = 0; cut < slopes.size(); ++cut)
            slopes[cut].perVoxel[lane] = float(glm::dot(direction, medium.cuts[cut].normal) / perWorld);
    }
}

/// Multiply transmittances by the medium's. @param left transmittance by direction
VDBLIC_KERNEL
void trace(const LightWays& ways, const glm::dvec3& point, Float8& left)
{
    const Medium& medium = ways.medium;
    const glm::dvec3 begin(medium.toIndex * glm::dvec4(point, 1));
    Float8 from[3], enter{}, leave = ways.farthest; // distances in voxels
    for (int axis = 0; axis < 3; ++axis) {
        from[axis] = broadcast8(float(begin[axis]));
        const Float8 low = float(medium.low[axis] - begin[axis]) * ways.inverse[axis];
        const Float8 high = float(medium.high[axis] - begin[axis]) * ways.inverse[axis];
        const Float8 first = low < high ? low : high, last = low < high ? high : low;
        enter = first > enter ? first : enter;
        leave = last < leave ? last : leave;
    }
    for (std::size_t cut = 0; cut < ways.slopes.size(); ++cut) {
        const auto height = float(medium.cuts[cut].height(point));
        const Float8 slope = ways.slopes[cut].perVoxel, crossing = -height / slope;
        enter = ((slope > 0) & (crossing > enter)) ? crossing : enter;
        leave = ((slope < 0) & (crossing < leave)) ? crossing : leave;
        if (height < 0) leave = slope == 0 ? Float8{} : leave;
    }
    if (!anyOf(enter < leave)) return;

    // The last step of a ray is shorter.
    const auto step = float(medium.step);
    Float8 sum{}, most{};
    const Float8 steps = (leave - enter) / step;
    for (int done = 0; anyOf(float(done) < steps); ++done) {
        const Float8 at = enter + float(done) * step, rest = leave - at,
                     length = positive(rest < step ? rest : broadcast8(step));
        const Float8 middle = at + 0.5f * length;
        const Float8 position[] = {from[0] + ways.unit[0] * middle, from[1] + ways.unit[1] * middle,
                                   from[2] + ways.unit[2] * middle};
        const Float8 value = medium.cells.at(medium.values, position) * powerOfTwo(ways.keep * middle);
        sum += value * length;
        const Float8 inside = length > 0 ? value : Float8{};
        most = inside > most ? inside : most;
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
    std::vector<Medium> media{mediumOf(casters)};
    std::optional<SolidCells> solidCells;
    if (casters.solid) {
        solidCells.emplace(*casters.solid);
        media.push_back(mediumOf(*solidCells, casters));
    }
    const double side = std::max(plane.half.x, plane.half.y) * 2;
    const double cellEdge = media[0].step / glm::length(glm::dmat3(media[0].toIndex) * plane.axes[0]);
    const double spacing = std::max(side / kMostAcross, cellEdge);
    mPerSpacing = 1 / spacing;
    mLow = plane.middle - plane.half - plane.fade;
    mSize = glm::ivec2(glm::ceil((plane.half + plane.fade) * 2.0 * mPerSpacing)) + 1;
    mLit.assign(std::size_t(mSize.x) * std::size_t(mSize.y), 1);

    const glm::dvec3 key = glm::normalize(towardsLight);
    const double never = std::numeric_limits<double>::infinity();
    double edges = 1;
    const glm::dvec3 extent = media[0].high - media[0].low;
    for (int axis = 0; axis < 3; ++axis)
        edges *= extent[axis] * glm::length(glm::dmat3(casters.box.indexToWorld())[axis]);
    const double reach = kReach * std::cbrt(edges);
    struct Bundle {
        std::vector<LightWays> through; // the media, one behind the other
        float share;                    // of the open ground's light
    };
    std::vector<Bundle> bundles;
    const auto add = [&](const std::vector<Directions>& directions, double length, double effect, float share) {
        for (const Directions& eight : directions) {
            Bundle& bundle = bundles.emplace_back(Bundle{{}, share / float(directions.size())});
            for (const Medium& medium : media)
                bundle.through.emplace_back(medium, eight, length, effect);
        }
    };
    if (glm::dot(key, plane.normal) > 0)
        add(directionsAround(key, kKeyRadius, kKeyDirections), never, never, kKeyShare);
    add(directionsAround(plane.normal, std::nullopt, kOpenDirections), kFarthest * reach, reach, 1 - kKeyShare);

    tbb::parallel_for(0, mSize.y, [&](int row) {
        for (int column = 0; column < mSize.x; ++column) {
            const glm::dvec2 place = mLow + glm::dvec2(column, row) * spacing;
            if (!(plane.alpha(place) > 0)) continue;
            const glm::dvec3 point = plane.at(place);
            float taken = 0;
            for (const Bundle& bundle : bundles) {
                Float8 left = broadcast8(1);
                for (const LightWays& ways : bundle.through)
                    trace(ways, point, left);
                float sum = 0;
                for (int lane = 0; lane < kLanes; ++lane)
                    sum += 1 - left[lane];
                taken += bundle.share * sum / kLanes;
            }
            mLit[std::size_t(row) * std::size_t(mSize.x) + std::size_t(column)] = 1 - taken;
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
