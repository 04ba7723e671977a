#pragma once

#include "vdblic/field/bricks.h"
#include "vdblic/field/slabs.h"
#include "vdblic/methods/auflic/local_contrast.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace vdblic {

/// A sharpened texture (sharpen.h), for sampling between voxels, with the contrast around each.
///
/// Only the open slabs are in memory. Any number of threads may read, but not while slabs are opened or closed.
class SharpTexture {
  public:
    /// @param texture  0 outside the domain; must outlive every open()
    /// @param strength of the sharpening
    /// @param slabs    of the domain; must outlive this
    SharpTexture(std::shared_ptr<const Domain> domain, const LeafValues<float>& texture, float strength,
                 const Slabs& slabs);

    /// Sharpen a slab, in parallel. Only leaves of open slabs can be sampled.
    void open(std::size_t slab);
    void close(std::size_t slab) { mBricks.release(mSlabs[slab]); }

    /// Contrast of the sharpened texture; valid around a leaf once its 26 neighbours are open.
    [[nodiscard]] const LocalContrast& contrast() const { return mContrast; }

    /// Means over the corners in the domain, and the corners' share of the weights (coverage). Without coverage a mean
    /// is undefined.
    struct Samples {
        Float8 value, coverage;
    };
    using Window = BricksOf<2>::Window;
    /// The window in which positions in and around a leaf are expected.
    [[nodiscard]] Window window(const openvdb::Coord& origin) const { return mBricks.window(origin); }

    /// Sample eight positions at once.
    /// @param window of window(), where the positions are expected; others are slower
    /// @param lanes  lanes to sample; the results of others have no meaning
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
    void sharpenSlab(std::size_t slab);
    void releaseValues(std::size_t slab);

    const LeafValues<float>& mTexture;
    float mStrength;
    const Slabs& mSlabs;
    LocalContrast mContrast;
    std::vector<std::unique_ptr<float[]>> mValues; // sharpened, of leaves that bricks to fill need
    std::vector<bool> mIsSharpened, mIsFilled;     // of each slab
    BricksOf<2> mBricks;
};

} // namespace vdblic
