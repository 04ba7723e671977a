#pragma once

#include "vdblic/camera/clipping.h"

#include <span>
#include <vector>

namespace vdblic {

class ExtinctionGrid;
class TextureVolume;
struct Look;
struct Solid;

/// Ambient occlusion: how much ambient light arrives in each cell of an ExtinctionGrid. It does not depend on the
/// camera.
///
/// Ambient light comes from fourteen directions (Lebedev's quadrature of degree 5, 1976). Optical depth decays along
/// its way, so that only near matter occludes. A factor is relative to the mean over all visible cells: occlusion gives
/// form and keeps the picture's brightness. Immutable; any number of threads may read.
class AmbientLight {
  public:
    /// @param visible   extinctions of the volume
    /// @param look      with the strength of occlusion
    /// @param solid     occludes too; or null  @param solidCuts that cut it, in world space
    AmbientLight(const ExtinctionGrid& visible, const TextureVolume& volume, const Look& look,
                 const Solid* solid = nullptr, std::span<const ClipPlane> solidCuts = {});

    /// Extinctions of volume and solid, by cell [1/voxel].
    [[nodiscard]] const std::vector<float>& extinctions() const { return mExtinctions; }
    /// Factors on the light, by cell.
    [[nodiscard]] const std::vector<float>& factors() const { return mFactors; }

  private:
    void addSolid(const TextureVolume& volume, const Solid& solid, std::span<const ClipPlane> cuts,
                  const ExtinctionGrid& grid);
    void occlude(const ExtinctionGrid& grid, double strength);

    std::vector<float> mExtinctions, mFactors;
};

} // namespace vdblic
