#pragma once

#include "vdblic/cast/lanes.h"

namespace vdblic {

class Camera;
class PlacedBox;
struct Look;

/// How far samples fade into the background with their depth: linearly, from the volume's nearest corner to its
/// farthest.
class DepthCue {
  public:
    DepthCue(const PlacedBox& box, const Look& look, const Camera& camera);

    [[nodiscard]] VDBLIC_INLINE Float8 share(Float8 depth) const { return clamped((depth - mNearest) * mPerDepth); }
    [[nodiscard]] float share(float depth) const { return share(broadcast8(depth))[0]; }

  private:
    float mNearest, mPerDepth;
};

} // namespace vdblic
