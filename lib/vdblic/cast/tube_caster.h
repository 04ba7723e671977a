#pragma once

#include "vdblic/camera/clipping.h"
#include "vdblic/cast/depth_cue.h"
#include "vdblic/cast/lighting.h"
#include "vdblic/cast/pixel_rays.h"
#include "vdblic/cast/surface_picture.h"
#include "vdblic/cast/tube_tree.h"
#include "vdblic/image/image.h"

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include <cstdint>
#include <optional>
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
    glm::vec3 color; ///< linear light, lit
    float far;       ///< share of the background in it
    float depth;     ///< along the view axis from the eye's plane [world]
    float driver, texture;
    glm::vec3 normal; ///< world space, of length 1
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

    /// Find the tubes on a ray inside all cuts, front to back, until little light is left.
    /// @param end depth of the surface behind
    /// @param see called with each tube
    template<typename See>
    void trace(const PixelRays::Line& pixel, double end, const See& see) const;

  private:
    struct Ray {
        TubeTree::Ray line;  ///< begins where cuts and the box's bounds let it
        glm::vec3 direction; ///< in world space, of length 1
        double begin;        ///< depth of its origin along the view axis [world]
        double depthPerUnit; ///< of the tubes' space
    };
    [[nodiscard]] std::optional<Ray> rayOf(const PixelRays::Line& pixel, double end) const;
    void light(const Ray& ray, const TubeTree::Hit* hits, int count, SeenTube* seen) const;
    Float8 arrivingLight(const Ray& ray, Float8 distance, const Float8* normal) const;

    const TubeTree& mTree;
    const Tubes& mTubes;
    const Look& mLook;
    const LightGrid* mLight;
    float mLeastTransmittance;
    double mVoxel; // of the light [tubes' space]
    std::vector<ClipPlane> mCuts;
    Lighting mLighting;
    DepthCue mCue;
    glm::dmat4 mToTubes, mToLight;
};

template<typename See>
void TubeCaster::trace(const PixelRays::Line& pixel, double end, const See& see) const
{
    const std::optional<Ray> ray = rayOf(pixel, end);
    if (!ray) return;
    float left = 1;
    TubeTree::Hit hits[TubeTree::kMostHits];
    SeenTube seen[TubeTree::kMostHits];
    int count = mTree.nearest(ray->line, nullptr, left, hits);
    while (count > 0) {
        light(*ray, hits, count, seen);
        for (int i = 0; i < count; ++i) {
            see(seen[i]);
            left -= left * seen[i].alpha;
        }
        if (count < TubeTree::kMostHits || left < mLeastTransmittance) return;
        const TubeTree::Hit last = hits[count - 1];
        count = mTree.nearest(ray->line, &last, left, hits);
    }
}

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
