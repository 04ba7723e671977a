#pragma once

#include "vdblic/cast/coarse_cells.h"
#include "vdblic/field/vector.h"

#include <glm/vec3.hpp>

#include <vector>

namespace vdblic {

class Camera;
class ExtinctionGrid;
class PlacedBox;
struct Look;
struct Solid;

/// Ambient occlusion: how much ambient light arrives in each cell of an ExtinctionGrid. It does not depend on the
/// camera.
///
/// Ambient light comes from fourteen directions (Lebedev's quadrature of degree 5, 1976). Optical depth decays with the
/// distance, so that only near matter occludes. A factor is relative to the mean over all visible cells: occlusion
/// gives form and keeps the picture's brightness. Immutable; any number of threads may read.
class AmbientLight {
  public:
    /// @param visible extinctions of the volume
    /// @param look    with the strength of occlusion
    /// @param solid   occludes too; or null
    AmbientLight(const ExtinctionGrid& visible, const PlacedBox& box, const Look& look, const Solid* solid = nullptr);

    /// Extinctions of volume and solid, by cell [1/voxel].
    [[nodiscard]] const std::vector<float>& extinctions() const { return mExtinctions; }
    /// Factors on the light, by cell.
    [[nodiscard]] const std::vector<float>& factors() const { return mFactors; }

  private:
    void addSolid(const PlacedBox& box, const Solid& solid, const ExtinctionGrid& grid);
    void occlude(const ExtinctionGrid& grid, double strength);

    std::vector<float> mExtinctions, mFactors;
};

/// Direction towards the light that casts shadows: the look's first distant light, else above and to the left of the
/// eye.
[[nodiscard]] glm::dvec3 keyLight(const Look& look, const Camera& camera);

/// The light that arrives inside a volume, on a coarse grid over its bounds: shadows of the key light, and ambient
/// occlusion. Immutable; any number of threads may read.
class LightGrid {
  public:
    /// @param visible      extinctions of the volume
    /// @param ambient      of the same grid
    /// @param look         with the strength of shadows
    /// @param towardsLight world space, any length but 0
    LightGrid(const ExtinctionGrid& visible, const AmbientLight& ambient, const PlacedBox& box, const Look& look,
              const glm::dvec3& towardsLight);

    /// Factors on the light: 1 − shadows · (1 − transmittance), times the factor of occlusion.
    /// @param position index space, by axis
    [[nodiscard]] VDBLIC_INLINE Float8 at(const Float8* position) const { return mCells.at(mFactors.data(), position); }
    [[nodiscard]] float at(const glm::dvec3& position) const;
    /// Edge of a cell [voxels].
    [[nodiscard]] int cell() const { return mCell; }

  private:
    int mCell; // edge [voxels]
    CoarseCells mCells;
    std::vector<float> mFactors;
};

} // namespace vdblic
