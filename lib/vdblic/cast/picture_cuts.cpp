#include "vdblic/cast/picture_cuts.h"

#include "vdblic/cast/ray_setup.h"
#include "vdblic/field/leaf_voxel.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <utility>

namespace vdblic {
namespace {

constexpr double kUnits = 1000; // of weight, in a ray as long as the box's diagonal

/// A rectangle of tiles.
struct TileArea {
    glm::ivec2 low, high;
};

/// Cuts the tiles of a picture in two until every rank has a part.
class TileCuts {
  public:
    TileCuts(const Camera& camera, const Corners& box);

    /// Where to cut an area in two. @param ranks of both parts  @return the first tile behind the cut
    [[nodiscard]] int cut(const TileArea& area, int axis, int firstRanks, int ranks) const;
    [[nodiscard]] glm::ivec2 tiles() const { return mTiles; }

  private:
    [[nodiscard]] std::int64_t weight(const TileArea& area) const;

    glm::ivec2 mTiles;
    std::vector<std::int64_t> mWeights; // of each tile, row by row
};

/// The length of a line's part in the unit cube, over the length of its direction.
double lengthInCube(const glm::dvec3& origin, const glm::dvec3& direction)
{
    double enter = 0, leave = HUGE_VAL;
    for (int axis = 0; axis < 3; ++axis) {
        const double a = -origin[axis] / direction[axis], b = (1 - origin[axis]) / direction[axis];
        enter = std::fmax(enter, std::fmin(a, b));
        leave = std::fmin(leave, std::fmax(a, b));
    }
    return leave > enter ? leave - enter : 0;
}

TileCuts::TileCuts(const Camera& camera, const Corners& box)
    : mTiles((camera.size() + RaySetup::kTile - 1) / RaySetup::kTile)
{
    const glm::dmat3 edges(box[1] - box[0], box[2] - box[0], box[4] - box[0]), toCube = glm::inverse(edges);
    const double diagonal = glm::distance(box[0], box[7]);
    for (int y = 0; y < mTiles.y; ++y) {
        for (int x = 0; x < mTiles.x; ++x) {
            const Ray ray = camera.ray((glm::dvec2(x, y) + 0.5) * double(RaySetup::kTile));
            const double length = lengthInCube(toCube * (ray.origin - box[0]), toCube * ray.direction);
            mWeights.push_back(1 + std::int64_t(std::fmin(length / diagonal, 1) * kUnits));
        }
    }
}

std::int64_t TileCuts::weight(const TileArea& area) const
{
    std::int64_t sum = 0;
    for (int y = area.low.y; y < area.high.y; ++y) {
        for (int x = area.low.x; x < area.high.x; ++x)
            sum += mWeights[std::size_t(y) * std::size_t(mTiles.x) + std::size_t(x)];
    }
    return sum;
}

int TileCuts::cut(const TileArea& area, int axis, int firstRanks, int ranks) const
{
    const std::int64_t wanted = weight(area) * firstRanks;
    std::int64_t before = 0, least = wanted;
    TileArea line = area;
    int best = area.low[axis];
    for (int i = area.low[axis]; i < area.high[axis]; ++i) {
        line.low[axis] = i;
        line.high[axis] = i + 1;
        before += weight(line) * ranks;
        if (std::abs(before - wanted) >= least) break;
        least = std::abs(before - wanted);
        best = i + 1;
    }
    return best;
}

/// The plane through the eye and a line of the picture, in world space.
glm::dvec4 planeThrough(const Camera& camera, int axis, int pixel)
{
    const double share = 2.0 * pixel / camera.size()[axis] - 1; // −1 at the left and at the top
    const glm::dmat4 rows = glm::transpose(camera.worldToCamera());
    const glm::dvec4 along = axis == 0 ? rows[0] : -rows[1];
    const bool perspective = camera.projection() == Projection::kPerspective;
    return along - (share * camera.halfExtent()[axis]) * (perspective ? rows[2] : glm::dvec4(0, 0, 0, 1));
}

double heightAbove(const glm::dvec4& plane, const glm::dvec3& position)
{
    return glm::dot(glm::dvec3(plane), position) + plane.w;
}

/// The middle of a leaf.
glm::dvec3 middleOf(const openvdb::Coord& origin)
{
    return glm::dvec3(origin[0], origin[1], origin[2]) + (LeafVoxel::kDim - 1) / 2.0;
}

} // namespace

PictureCuts::PictureCuts(const Camera& camera, const Corners& box, int ranks)
{
    if (const std::optional<Lens> lens = camera.lens()) {
        mLens = glm::length(lens->right);
        mDepth = glm::transpose(camera.worldToCamera())[2] * lens->perDepth;
    }
    const TileCuts tiles(camera, box);
    for (int rank = 0; rank < ranks; ++rank) {
        TileArea area{glm::ivec2(0), tiles.tiles()};
        std::vector<PictureCut> cuts;
        for (int first = 0, count = ranks; count > 1;) {
            const glm::ivec2 size = area.high - area.low;
            const int axis = size.x >= size.y ? 0 : 1, half = count / 2;
            const int at = tiles.cut(area, axis, half, count);
            const bool isAfter = rank >= first + half;
            cuts.push_back({planeThrough(camera, axis, at * RaySetup::kTile), isAfter});
            (isAfter ? area.low : area.high)[axis] = at;
            first += isAfter ? half : 0;
            count = isAfter ? count - half : half;
        }
        const auto pixels = [&](const glm::ivec2& tile) { return glm::min(tile * RaySetup::kTile, camera.size()); };
        mAreas.push_back({pixels(area.low), pixels(area.high)});
        mCuts.push_back(std::move(cuts));
    }
}

ViewShare::ViewShare(const PictureCuts& cuts, int rank, const glm::dmat4& indexToWorld)
    : LeafShare(cuts.ranks()), mCuts(cuts.cuts(rank)), mLens(cuts.lens()),
      mDepth(glm::transpose(indexToWorld) * cuts.depth())
{
    for (PictureCut& cut : mCuts)
        cut.plane = glm::transpose(indexToWorld) * cut.plane;
}

bool ViewShare::owns(const openvdb::Coord& origin) const
{
    return std::all_of(mCuts.begin(), mCuts.end(), [&](const PictureCut& cut) {
        return (heightAbove(cut.plane, middleOf(origin)) >= 0) == cut.isAfter;
    });
}

bool ViewShare::needs(const openvdb::Coord& origin, int rim) const
{
    const double reach = LeafVoxel::kDim / 2.0 + rim + 1; // of the leaf with its rim; a voxel more against rounding
    const glm::dvec3 deepening = glm::abs(glm::dvec3(mDepth));
    const double stray = mLens * (std::abs(heightAbove(mDepth, middleOf(origin)) - 1) +
                                  reach * (deepening.x + deepening.y + deepening.z));
    return std::all_of(mCuts.begin(), mCuts.end(), [&](const PictureCut& cut) {
        const glm::dvec3 normal = glm::abs(glm::dvec3(cut.plane));
        const double height = heightAbove(cut.plane, middleOf(origin));
        return (cut.isAfter ? height : -height) + reach * (normal.x + normal.y + normal.z) + stray >= 0;
    });
}

} // namespace vdblic
