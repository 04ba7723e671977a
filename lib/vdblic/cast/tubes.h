#pragma once

#include "vdblic/field/vector.h"
#include "vdblic/lines/lines.h"
#include "vdblic/look/volume_values.h"
#include "vdblic/volume/placed_box.h"

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <span>
#include <vector>

namespace vdblic {

/// Lines as tubes: between two points of a line lies the hull of two spheres, a round cone. Immutable; any number of
/// threads may read.
class Tubes : public PlacedBox {
  public:
    /// The values of the scalars that opacity and colour follow, one a point; NaN where there is none.
    struct Values {
        std::vector<float> driver, color; ///< colour is empty if the driver colours
    };

    /// @param transform of the lines' index space
    /// @param stretch   factors along the axes from the lines' world space to the picture's
    /// @param isShown   whether the parts of lines in a voxel of that index space are shown
    Tubes(const Lines& lines, Values values, const openvdb::math::Transform& transform, const glm::dvec3& stretch,
          const std::function<bool(const openvdb::Coord&)>& isShown);

    [[nodiscard]] bool empty() const { return mCones.empty(); }
    /// Cones that are left out because a scalar is not a finite number.
    [[nodiscard]] std::size_t unusable() const { return mUnusable; }
    /// Estimated memory [bytes].
    [[nodiscard]] double bytes() const;

    /// Values at a few hundred thousand places, evenly spaced along all lines; the texture is the lines' opacity.
    [[nodiscard]] VolumeSamples samples() const;
    /// Mean number of tubes that a straight line through the box meets (Cauchy's formula 1841).
    [[nodiscard]] double crossings() const;
    /// The least and the greatest value of the scalar that opacity follows.
    [[nodiscard]] LeafRange range() const;

    /// A part of a tube short enough for constant values.
    struct Piece {
        glm::dvec3 place; ///< index space of the box
        float driver, opacity;
        double area; ///< of its shadow, in the mean over all directions [faces of a voxel]
    };
    /// Call a function for the pieces of cones, in order. A piece is no longer than a cell of the light, except in very
    /// long cones.
    /// @param cones their numbers  @param cell edge of a cell [voxels of the box]
    template<typename Use>
    void forPieces(std::span<const std::uint32_t> cones, int cell, const Use& use) const;

    /// From the picture's world to the tubes' own space, whose unit is about a voxel.
    [[nodiscard]] const glm::dmat4& worldToTubes() const { return mWorldToTubes; }
    [[nodiscard]] double unitsPerWorld() const { return mUnitsPerWorld; }
    /// A value on a cone. @param values one a point; if one end is NaN, the other end's
    [[nodiscard]] static float valueAt(const std::vector<float>& values, std::uint32_t first, float share);
    [[nodiscard]] VDBLIC_INLINE static Float8 valuesAt(const std::vector<float>& values, std::uint32_t first,
                                                       Float8 share)
    {
        return between(broadcast8(values[first]), broadcast8(values[first + 1]), share);
    }
    /// The same of a cone in each lane.
    [[nodiscard]] VDBLIC_INLINE static Float8 valuesAt(const std::vector<float>& values,
                                                       const std::uint32_t (&first)[kLanes], Float8 share)
    {
        Float8 a, b;
        for (int lane = 0; lane < kLanes; ++lane) {
            a[lane] = values[first[lane]];
            b[lane] = values[first[lane] + 1];
        }
        return between(a, b, share);
    }
    [[nodiscard]] const std::vector<float>& drivers() const { return mValues.driver; }
    [[nodiscard]] const std::vector<float>& colors() const { return mValues.color; }
    [[nodiscard]] const std::vector<float>& opacities() const { return mOpacities; }

    struct Point {
        float x, y, z, radius; ///< the tubes' own space
    };
    /// Between two consecutive points.
    struct Cone {
        std::uint32_t first; ///< of its points
        std::int32_t line;   ///< its line's id
        bool hasPrevious, hasNext;
    };
    /// The two points of a cone; its line's other points stand before and after them.
    [[nodiscard]] const Point* points(std::uint32_t cone) const { return mPoints.data() + mCones[cone].first; }
    [[nodiscard]] const std::vector<Cone>& cones() const { return mCones; }

  private:
    [[nodiscard]] VDBLIC_INLINE static Float8 between(Float8 a, Float8 b, Float8 share)
    {
        const Float8 value = b == b ? a + (b - a) * share : a;
        return a == a ? value : b; // not for NaN
    }
    void place(const Lines& lines, double perRadius);
    /// In the tubes' own space; of a line's last cone with that of a cylinder whose shadow is the ends'.
    [[nodiscard]] double length(std::uint32_t cone) const;

    std::vector<Point> mPoints;
    std::vector<float> mOpacities;
    Values mValues;
    std::vector<Cone> mCones;
    std::size_t mUnusable = 0;
    glm::dmat4 mWorldToTubes{1};
    double mUnitsPerWorld = 1;
};

template<typename Use>
void Tubes::forPieces(std::span<const std::uint32_t> cones, int cell, const Use& use) const
{
    constexpr double kMostPieces = 1000;
    const double voxel = voxelSize() * mUnitsPerWorld;
    const glm::dmat4 toIndex = worldToIndex() * glm::inverse(mWorldToTubes);
    for (const std::uint32_t cone : cones) {
        const Point* const ends = points(cone);
        const double all = length(cone);
        const int pieces = int(std::min(std::ceil(all / (cell * voxel)), kMostPieces));
        for (int i = 0; i < pieces; ++i) {
            const float share = (float(i) + 0.5f) / float(pieces);
            const auto mix = [share](float a, float b) { return a + (b - a) * share; };
            const glm::dvec3 at(mix(ends[0].x, ends[1].x), mix(ends[0].y, ends[1].y), mix(ends[0].z, ends[1].z));
            const double width = 2 * double(mix(ends[0].radius, ends[1].radius)); // × π/4: of the mean shadow
            const std::uint32_t first = mCones[cone].first;
            use(Piece{glm::dvec3(toIndex * glm::dvec4(at, 1)), valueAt(mValues.driver, first, share),
                      valueAt(mOpacities, first, share),
                      std::numbers::pi / 4 * width * all / (pieces * voxel * voxel)});
        }
    }
}

} // namespace vdblic
