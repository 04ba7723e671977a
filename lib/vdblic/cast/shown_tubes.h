#pragma once

#include "vdblic/cast/lanes.h"
#include "vdblic/cast/tubes.h"
#include "vdblic/field/vector.h"
#include "vdblic/look/look.h"

#include <cstdint>
#include <numbers>
#include <vector>

namespace vdblic {

/// The tubes that a look shows. Immutable; any number of threads may read.
class ShownTubes {
  public:
    /// @param tubes must outlive this
    ShownTubes(const Tubes& tubes, const Look& look);

    [[nodiscard]] const Tubes& tubes() const { return mTubes; }
    /// The cones with a visible part, in order.
    [[nodiscard]] const std::vector<std::uint32_t>& cones() const { return mCones; }
    /// The alphas of tubes. @param driver not NaN  @param opacity of the lines  @param halo see halo()
    [[nodiscard]] VDBLIC_INLINE Float8 alpha(Float8 driver, Float8 opacity, Float8 halo = Float8{}) const
    {
        const Int8 entries = mTransfer.entries(driver);
        Float8 extinction{};
        for (int lane = 0; lane < kLanes; ++lane)
            extinction[lane] = mTransfer.extinctions()[entries[lane]];
        const Float8 density = mTexture.density(mTexture.stretched(opacity));
        return 1 - powerOfTwo(-std::numbers::log2e_v<float> * extinction * density * (1 + halo));
    }
    /// The ratio of a halo's extinction to its tube's. @param cosine of the angle between the tube's normal and the ray
    [[nodiscard]] VDBLIC_INLINE Float8 halo(Float8 cosine) const
    {
        return mHalo.strength * Halo::edge(cosine * cosine);
    }

  private:
    const Tubes& mTubes;
    TransferFunction mTransfer;
    TextureModulation mTexture;
    Halo mHalo;
    std::vector<std::uint32_t> mCones;
};

} // namespace vdblic
