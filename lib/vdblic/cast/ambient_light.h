#pragma once

#include "vdblic/camera/clipping.h"

#include <span>
#include <vector>

namespace vdblic {

class ExtinctionGrid;
class TextureVolume;
struct Look;
struct Solid;

/// What of the light from everywhere arrives in the cells of an ExtinctionGrid: ambient occlusion. It does not depend
/// on the camera.
///
/// Ambient light is that of fourteen directions (Lebedev's quadrature of degree 5, 1976); on its way optical depth is
/// forgotten, so that only what is near occludes. A factor is relative to the mean of what is visible: occlusion gives
/// form and takes no light away. Immutable; any number of threads may read.
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
