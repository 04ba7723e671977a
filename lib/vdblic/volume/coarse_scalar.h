#pragma once

#include "vdblic/field/refinement.h"

#include <openvdb/openvdb.h>

#include <optional>

namespace vdblic {

/// A scalar on voxels that a texture refines, at the texture's voxels: trilinear between those of the eight corners
/// that are active, whose weights are brought up to 1 (as resampled()).
///
/// Any number of threads may read.
class CoarseScalar {
  public:
    /// @return nothing if the texture's voxels do not refine the scalar's
    [[nodiscard]] static std::optional<CoarseScalar> of(const openvdb::FloatGrid& scalar,
                                                        const openvdb::FloatGrid& texture);

    /// Set the values of a cube of texture voxels.
    /// @param first  its first voxel
    /// @param dim    voxels of a side, kMostDim at most
    /// @param values x slowest; NaN where no corner is active
    void sample(const openvdb::Coord& first, int dim, float* values) const;

    static constexpr int kMostDim = 12;

  private:
    CoarseScalar(const openvdb::FloatGrid& scalar, const Refinement& refinement)
        : mTree(scalar.tree()), mRefinement(refinement)
    {
    }

    const openvdb::FloatTree& mTree; // of the scalar
    Refinement mRefinement;
};

} // namespace vdblic
