#pragma once

#include "vdblic/cast/shown_tubes.h"
#include "vdblic/field/vector.h"

#include <memory>
#include <vector>

struct RTCSceneTy;

namespace vdblic {

/// The tubes that a look shows, in a tree for ray casting.
///
/// Embree (Wald et al. 2014) finds the cones near a ray; where a ray enters one is computed here, so that pixels depend
/// neither on the processor nor on Embree's version. Immutable; any number of threads may read.
class TubeTree : public ShownTubes {
  public:
    /// @param tubes must outlive this
    /// @throws std::bad_alloc if Embree has too little memory
    TubeTree(const Tubes& tubes, const Look& look);

    /// The two points of a cone.
    struct alignas(32) Ends {
        Tubes::Point first, second;
    };
    /// Of the visible cones: together in memory, since most of them are missed by the rays that come near.
    [[nodiscard]] const std::vector<Ends>& ends() const { return mEnds; }

    /// Rays in the tubes' own space, one a lane. Their search may be continued.
    struct Rays {
        Vector8 origin{}, direction{}; ///< the directions have length 1
        Float8 end{};
        Float8 least{};                    ///< transmittance below which a ray ends
        Int8 isActive{};                   ///< whether a ray may have further hits
        Float8 left = broadcast8(1);       ///< transmittance behind the last hit so far
        Float8 last{};                     ///< distance of that hit
        Int8 lastCone = broadcastInt8(-1); ///< its index in cones()
    };
    /// Where rays enter tubes, one a lane.
    struct Hits {
        Int8 isThere;
        Float8 distance;
        Int8 cone;
        Float8 share;   ///< position between the cone's first point, 0, and its second, 1
        Float8 alpha;   ///< of the tube and its halo; 0 where there is no hit
        Vector8 normal; ///< outward, of length 1
    };
    static constexpr int kMostHits = 16;

    /// The next places where rays enter visible tubes, in order: by distance, then by the number of the cone. The last
    /// one may absorb the rest of a ray's light. Rays that are near each other take less time.
    /// @param hits receives up to kMostHits of each ray
    /// @return the most hits that a ray has; 0 if no ray has any more
    int next(Rays& rays, Hits* hits) const;

  private:
    std::vector<Ends> mEnds;
    std::shared_ptr<RTCSceneTy> mScene;
};

} // namespace vdblic
