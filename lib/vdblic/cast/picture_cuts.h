#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/volume/leaf_share.h"

#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

#include <vector>

namespace vdblic {

/// A line that cuts a picture: with the eye a plane, which cuts space.
struct PictureCut {
    glm::dvec4 plane; ///< with a position (x, y, z, 1) above 0 to the right of the line or below it
    bool isAfter;     ///< which side is meant: to the right or below, the plane included; else the other
};

/// A picture cut among ranks into rectangles of tiles, in which rays pass through a box for about equal lengths.
/// Immutable.
class PictureCuts {
  public:
    /// @param box around the visible volume, in world space
    PictureCuts(const Camera& camera, const Corners& box, int ranks);

    [[nodiscard]] int ranks() const { return int(mAreas.size()); }
    [[nodiscard]] const PictureArea& area(int rank) const { return mAreas[std::size_t(rank)]; }
    /// The cuts around a rank's part. The parts fill space, also outside of the picture.
    [[nodiscard]] const std::vector<PictureCut>& cuts(int rank) const { return mCuts[std::size_t(rank)]; }
    /// Bound on the distance of the lens's rays from its central ray [unit of the cuts' heights]: lens() · |depth − 1|,
    /// with the depth relative to the focal plane's, depth() · (x, y, z, 1).
    [[nodiscard]] double lens() const { return mLens; }
    [[nodiscard]] const glm::dvec4& depth() const { return mDepth; }

  private:
    std::vector<PictureArea> mAreas;
    std::vector<std::vector<PictureCut>> mCuts;
    double mLens = 0;
    glm::dvec4 mDepth{0};
};

/// The leaves of a volume that the rays of a part of the picture see, or that lie in that part of space.
class ViewShare final : public LeafShare {
  public:
    ViewShare(const PictureCuts& cuts, int rank, const glm::dmat4& indexToWorld);

    [[nodiscard]] bool owns(const openvdb::Coord& origin) const override;
    [[nodiscard]] bool needs(const openvdb::Coord& origin, int rim) const override;

  private:
    std::vector<PictureCut> mCuts; // in index space
    double mLens;
    glm::dvec4 mDepth; // as PictureCuts has it, of a position in index space
};

} // namespace vdblic
