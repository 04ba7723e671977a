#pragma once

#include "vdblic/field/refinement.h"

#include <openvdb/openvdb.h>

#include <array>
#include <optional>

namespace vdblic {

/// A scalar on voxels that a texture refines, cut into pieces for the texture's leaves.
///
/// Any number of threads may read.
class CoarseScalar {
  public:
    /// @return nothing if the texture's voxels do not refine the scalar's
    [[nodiscard]] static std::optional<CoarseScalar> of(const openvdb::FloatGrid& scalar,
                                                        const openvdb::FloatGrid& texture);

    /// Number of coarse voxels along the axes that samples in a leaf of the texture depend on, at most.
    [[nodiscard]] std::array<int, 3> dim() const;
    /// Coarse voxels in one of the texture's, along an axis.
    [[nodiscard]] float scale(int axis) const { return mRefinement.scale(axis); }

    /// What a leaf needs.
    struct Piece {
        openvdb::Coord first; ///< coarse voxel
        float offset[3];      ///< position of the leaf's origin relative to it [coarse voxels]
    };
    /// @param origin of the leaf
    [[nodiscard]] Piece pieceOf(const openvdb::Coord& origin) const;

    /// Copy the values of a piece.
    ///
    /// An inactive voxel has the mean of its nearest active neighbours, of those in the piece that share a face, else
    /// an edge, else a corner; 0 if there is none.
    /// @param values receives dim() numbers, x slowest
    /// @return least and largest of the active values; nothing if there is none
    [[nodiscard]] std::optional<std::array<float, 2>> copy(const Piece& piece, float* values) const;

  private:
    CoarseScalar(const openvdb::FloatGrid& scalar, const Refinement& refinement)
        : mTree(scalar.tree()), mRefinement(refinement)
    {
    }

    const openvdb::FloatTree& mTree; // of the scalar
    Refinement mRefinement;
};

} // namespace vdblic
