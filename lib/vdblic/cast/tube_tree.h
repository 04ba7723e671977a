#pragma once

#include "vdblic/cast/tubes.h"
#include "vdblic/look/look.h"

#include <cstdint>
#include <memory>
#include <vector>

struct RTCSceneTy;

namespace vdblic {

/// The tubes that a look shows, in a tree for ray casting.
///
/// Embree (Wald et al. 2014) finds the cones near a ray; where a ray enters one is computed here, so that pixels depend
/// neither on the processor nor on Embree's version. Immutable; any number of threads may read.
class TubeTree {
  public:
    /// @param tubes must outlive this
    /// @throws std::bad_alloc if Embree has too little memory
    TubeTree(const Tubes& tubes, const Look& look);

    [[nodiscard]] const Tubes& tubes() const { return mTubes; }
    /// The cones with a visible part, in order.
    [[nodiscard]] const std::vector<std::uint32_t>& cones() const { return mCones; }
    /// The alpha of a tube. @param driver not NaN  @param opacity of the line
    [[nodiscard]] float alpha(float driver, float opacity) const;

    /// Where a ray enters a tube.
    struct Hit {
        float distance;
        std::uint32_t cone;
        float share;     ///< position between the cone's first point, 0, and its second, 1
        float alpha;     ///< of the tube
        float normal[3]; ///< outward, of length 1
    };
    /// A ray in the tubes' own space.
    struct Ray {
        float origin[3], direction[3]; ///< the direction has length 1
        float end;
        float leastTransmittance; ///< below which it ends
    };
    static constexpr int kMostHits = 8;

    /// The nearest places where a ray enters visible tubes, in order: by distance, then by the number of the cone.
    /// @param after  skip hits up to this one; null: skip none
    /// @param left   transmittance before the first hit
    /// @param hits   receives up to kMostHits; the last one may absorb the rest of the light
    /// @return their number
    int nearest(const Ray& ray, const Hit* after, float left, Hit* hits) const;

  private:
    const Tubes& mTubes;
    TransferFunction mTransfer;
    TextureModulation mTexture;
    std::vector<std::uint32_t> mCones;
    std::shared_ptr<RTCSceneTy> mScene;
};

} // namespace vdblic
