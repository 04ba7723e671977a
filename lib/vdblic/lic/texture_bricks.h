#pragma once

#include "vdblic/field/bricks.h"
#include "vdblic/field/slabs.h"

#include <cstddef>
#include <memory>

namespace vdblic {

/// A texture, to be sampled between voxels. Any number of threads may sample, and none
/// while leaves are filled or released.
class TextureBricks {
  public:
    /// @param texture 0 outside the domain; must outlive every fill()
    TextureBricks(std::shared_ptr<const Domain> domain, const LeafValues<float>& texture);

    /// Only leaves that were filled and not released can be sampled.
    void fill(Slabs::Leaves leaves);
    void release(Slabs::Leaves leaves) { mBricks.release(leaves); }

    /// Means over the corners in the domain, and the corners' share of the weights; without coverage a mean has no
    /// meaning.
    struct Samples {
        Float8 value, coverage;
    };
    using Window = BricksOf<2>::Window;
    /// The window in which positions in and around a leaf are expected.
    [[nodiscard]] Window window(const openvdb::Coord& origin) const { return mBricks.window(origin); }

    /// Sample eight positions at once.
    /// @param window of window(), around where they are expected; elsewhere sampling is slower
    /// @param lanes  those to sample; the others' results have no meaning
    [[nodiscard]] VDBLIC_INLINE Samples at(const Window& window, const Vector8& position, unsigned lanes) const
    {
        Float2 rows[8];
        mBricks.interpolate(window, position, lanes, rows);
        Float8 sum, coverage;
        for (int lane = 0; lane < kLanes; ++lane) {
            sum[lane] = rows[lane][0];
            coverage[lane] = rows[lane][1];
        }
        return {sum / coverage, coverage};
    }

  private:
    const LeafValues<float>& mTexture;
    BricksOf<2> mBricks;
};

} // namespace vdblic
