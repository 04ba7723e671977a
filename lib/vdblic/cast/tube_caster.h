#pragma once

#include "vdblic/camera/clipping.h"
#include "vdblic/cast/depth_cue.h"
#include "vdblic/cast/lighting.h"
#include "vdblic/cast/pixel_rays.h"
#include "vdblic/cast/surface_picture.h"
#include "vdblic/cast/tube_tree.h"
#include "vdblic/field/vector.h"
#include "vdblic/image/image.h"

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include <cstdint>
#include <stop_token>
#include <vector>

namespace vdblic {

class Camera;
class LightGrid;
struct Look;
struct RayCastParams;

/// A tube where a ray enters it.
struct SeenTube {
    float alpha;
    float gap;       ///< share of its halo in alpha, which shows what is behind all tubes
    glm::vec3 color; ///< linear light, lit; of the rest
    float far;       ///< share of the background in the colour
    float depth;     ///< along the view axis from the eye's plane [world]
    float driver, texture;
    glm::vec3 normal; ///< world space, of length 1
};

/// Tubes where rays enter them, one a lane.
struct SeenTubes {
    Int8 isSeen;
    Float8 alpha, gap;
    Vector8 color;
    Float8 far, depth, driver, texture;
    Vector8 normal;

    [[nodiscard]] SeenTube lane(int i) const
    {
        return {.alpha = alpha[i],
                .gap = gap[i],
                .color = {color.x[i], color.y[i], color.z[i]},
                .far = far[i],
                .depth = depth[i],
                .driver = driver[i],
                .texture = texture[i],
                .normal = {normal.x[i], normal.y[i], normal.z[i]}};
    }
};

/// Finds the tubes on the rays of a picture, and lights them as surfaces. A tube has one alpha wherever a ray enters
/// it: one voxel's under the look's transfer function, with the line's own opacity as the texture's density. A ray that
/// starts inside a tube, at a cut, does not see that tube. Immutable; any number of threads may read.
class TubeCaster {
  public:
    /// @param tree   of the look
    /// @param params valid
    /// @param box    in whose index space the light is, and with whose depth colours fade
    /// @param light  or null
    TubeCaster(const TubeTree& tree, const Look& look, const Camera& camera, const RayCastParams& params,
               const PlacedBox& box, const LightGrid* light);

    /// Rays that are traced together, one a lane.
    struct Packet {
        TubeTree::Rays lines{}; ///< they begin where cuts and the box's bounds let them
        Vector8 direction{};    ///< in world space, of length 1
        Float8 begin{};         ///< depth of the origin along the view axis [world]
        Float8 depthPerUnit{};  ///< of the tubes' space
    };
    /// Put a ray into a lane of a packet. @param end depth of the surface behind
    void add(const PixelRays::Line& pixel, double end, int lane, Packet& packet) const;

    static constexpr int kMostTubes = TubeTree::kMostHits;
    /// Find the next tubes on rays inside all cuts, front to back, until little light is left.
    /// @param tubes receives up to kMostTubes of each ray
    /// @return their number, of the ray with the most; 0 at the end
    int next(Packet& packet, SeenTubes* tubes) const;

  private:
    SeenTubes light(const Packet& packet, const TubeTree::Hits& hits) const;
    Float8 arrivingLight(const Packet& packet, const TubeTree::Hits& hits) const;

    const TubeTree& mTree;
    const Tubes& mTubes;
    const Look& mLook;
    const LightGrid* mLight;
    float mLeastTransmittance;
    double mVoxel; // of the light [tubes' space]
    double mReach; // from the middle of the box [tubes' space]
    std::vector<ClipPlane> mCuts;
    Lighting mLighting;
    DepthCue mCue;
    glm::dmat4 mToTubes, mToLight;
};

/// Cast a ray through each pixel's centre and blend the tubes that it enters, front to back, with early termination.
/// The pixels do not depend on the number of threads. Thread-safe.
/// @param tree    of the look
/// @param params  valid
/// @param ray, scenery, only, stop as in castRays()
/// @throws Stopped if a stop was requested
[[nodiscard]] Image castTubes(const TubeTree& tree, const Look& look, const Camera& camera, const RayCastParams& params,
                              int ray = 0, const Scenery& scenery = {}, const std::uint8_t* only = nullptr,
                              const std::stop_token& stop = {});

} // namespace vdblic
