#pragma once

#include "vdblic/camera/clipping.h"
#include "vdblic/cast/ground_plane.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <span>
#include <vector>

namespace vdblic {

class ExtinctionGrid;
class PlacedBox;
struct Solid;

/// The volume and the solid that cast shadows on a ground.
struct ShadowCasters {
    const ExtinctionGrid& visible;
    const PlacedBox& box;              ///< whose extinctions `visible` are
    std::span<const ClipPlane> cuts{}; ///< of the volume, in world space
    const Solid* solid = nullptr;
};

/// The light that arrives at a ground, on a lattice over it: the key light through volume and solid, and ambient light,
/// which near matter occludes.
///
/// The key light is a disc of a few degrees: shadows are sharp at the foot of their caster and get softer with its
/// distance. Ambient light comes from 32 directions, with Lambert's cosine in their density; occlusion decays
/// with the distance. Both go through coarse cells: the volume's extinctions, and the parts of cells
/// that are inside the solid. Immutable; any number of threads may read.
class GroundLight {
  public:
    /// @param towardsLight world space, any length but 0; from behind the ground it casts no shadow
    GroundLight(const GroundPlane& plane, const ShadowCasters& casters, const glm::dvec3& towardsLight);

    /// Share of the light of an open ground, 0 to 1. @param place coordinates in the plane
    [[nodiscard]] float at(const glm::dvec2& place) const;

  private:
    glm::dvec2 mLow;    // of the first point
    double mPerSpacing; // points in a unit of length
    glm::ivec2 mSize{2};
    std::vector<float> mLit;
};

} // namespace vdblic
