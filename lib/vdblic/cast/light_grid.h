#pragma once

#include "vdblic/field/vector.h"

#include <glm/vec3.hpp>
#include <openvdb/openvdb.h>

#include <cstddef>
#include <vector>

namespace vdblic {

class Camera;
class Exchange;
class TextureVolume;
struct Look;
struct Solid;

/// Direction towards the light that casts shadows: the look's first distant light, else above and to the left of the
/// eye.
[[nodiscard]] glm::dvec3 keyLight(const Look& look, const Camera& camera);

/// The share of the key light that gets through the volume, on a coarse grid over its bounds: shadows.
///
/// A cell holds the mean extinction of its voxels. Optical depth is swept through the grid away from the light, slab by
/// slab, interpolated between the cells of the slab before. Cells are cubes of 2 voxels or more, so many that their
/// number stays below a million whatever the volume's extent. Ranks that share the volume add up their own leaves.
/// Immutable; any number of threads may read.
class LightGrid {
  public:
    /// @param towardsLight world space, any length but 0
    /// @param strength     of shadows: 0 none; 1: where no light arrives it is black
    /// @param solid        casts a shadow too; or null
    /// @param exchange     of the ranks that share the volume: collective
    LightGrid(const TextureVolume& volume, const Look& look, const glm::dvec3& towardsLight, double strength,
              const Solid* solid, Exchange& exchange);

    /// Factors on the light, 1 − strength · (1 − transmittance). @param position index space, by axis
    void at(const Float8* position, Float8& result) const;
    [[nodiscard]] float at(const glm::dvec3& position) const;

  private:
    [[nodiscard]] std::size_t index(const openvdb::Coord& cell) const
    {
        return (std::size_t(cell[0]) * std::size_t(mDim[1]) + std::size_t(cell[1])) * std::size_t(mDim[2]) +
               std::size_t(cell[2]);
    }
    [[nodiscard]] std::vector<float> meanExtinctions(const TextureVolume& volume, const Look& look,
                                                     Exchange& exchange) const;
    void addSolid(const TextureVolume& volume, const Solid& solid, std::vector<float>& extinctions) const;
    void sweep(const glm::dvec3& towardsLight, std::vector<float>& extinctions);

    openvdb::Coord mOrigin{0}, mDim{1}; // of the first cell [voxels]; number of cells
    int mCell = 2;                      // edge [voxels]
    std::vector<float> mFactors;
};

} // namespace vdblic
