#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/cast/pixel_rays.h"
#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/ray_setup.h"
#include "vdblic/cast/supersampling.h"
#include "vdblic/cast/surface_picture.h"
#include "vdblic/cast/tube_caster.h"
#include "vdblic/image/image.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/texture_volume.h"

#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace vdblic {

/// Rays that tubes divide into parts, which are cast one after the other.
class DividedRays {
  public:
    /// @param surfaces where rays end, or null
    DividedRays(const Scenery& scenery, const TextureVolume& volume, const Look& look, const Camera& camera,
                const RayCastParams& params, int ray, const SurfacePicture* surfaces, const std::uint8_t* only)
        : mTubes(*scenery.tubes, *scenery.tubesLook, camera, params, volume, scenery.light), mRays(camera, ray),
          mArea(camera.area()), mWidth(camera.size().x),
          mBrightness(float(std::exp2(scenery.tubesLook->exposure - look.exposure))),
          mLeastTransmittance(float(params.leastTransmittance)), mSurfaces(surfaces), mOnly(only)
    {
        const std::size_t count = std::size_t(camera.size().x) * std::size_t(camera.size().y);
        mBegins.resize(count);
        mEnds.resize(count);
        mIsActive.resize(count);
    }

    [[nodiscard]] const float* begins() const { return mBegins.data(); }
    [[nodiscard]] const float* ends() const { return mEnds.data(); }
    [[nodiscard]] const std::uint8_t* active() const { return mIsActive.data(); }

    /// The rays of a tile. Thread-safe for distinct tiles.
    class Tile {
      public:
        Tile(DividedRays& rays, const glm::ivec2& low, const std::vector<glm::vec3>& background) : mRays(rays)
        {
            const glm::ivec2 high = glm::min(low + RaySetup::kTile, rays.mArea.high);
            for (int y = low.y; y < high.y; ++y) {
                for (int x = low.x; x < high.x; x += kLanes)
                    add(x, std::min(x + kLanes, high.x), y, background[std::size_t(y)]);
            }
            for (const Divided& ray : mDivided)
                setPart(ray);
        }

        [[nodiscard]] bool isOver() const { return mDivided.empty(); }
        /// What is at the end of a ray's part. @param pixel of an active ray
        [[nodiscard]] glm::vec4 end(std::size_t pixel) const
        {
            const Divided& ray = *std::ranges::lower_bound(mDivided, pixel, {}, &Divided::pixel);
            if (ray.next < ray.last) return mColors[ray.next];
            return mRays.surfaceColor(pixel);
        }
        /// Blend the tubes at the ends of the parts into the image, and go on with the next parts.
        void next(Image& image)
        {
            for (Divided& ray : mDivided) {
                glm::vec4& pixel = image.pixels[ray.pixel];
                if (ray.next == ray.last) {
                    ray.isOver = true;
                } else {
                    blend(image, ray.pixel, mColors[ray.next], layersOf(mSeen[ray.next]));
                    ++ray.next;
                    ray.isOver = 1 - pixel.a < mRays.mLeastTransmittance;
                }
                if (ray.isOver && !image.layers.empty()) divideLayers(image.layers[ray.pixel], pixel.a);
                mRays.mBegins[ray.pixel] = mRays.mEnds[ray.pixel];
                setPart(ray);
            }
            std::erase_if(mDivided, [](const Divided& ray) { return ray.isOver; });
        }
        /// Blend a part of a ray, or a tube, behind those before. Layers are sums until the ray is over.
        static void blend(Image& image, std::size_t pixel, const glm::vec4& color, const PixelLayers& layers)
        {
            const float left = 1 - image.pixels[pixel].a;
            image.pixels[pixel] += color * left;
            if (!image.layers.empty()) addLayers(image.layers[pixel], layers, color.a * left);
        }

      private:
        struct Divided {
            std::size_t pixel, next, last; ///< the next tube, and the end of the ray's tubes
            bool isOver = false;
        };

        /// Trace the pixels of a row from one to before another, at most kLanes.
        void add(int begin, int end, int y, const glm::vec3& background)
        {
            const std::size_t row = std::size_t(y) * std::size_t(mRays.mWidth);
            TubeCaster::Packet packet;
            for (int x = begin; x < end; ++x) {
                const std::size_t pixel = row + std::size_t(x);
                mRays.mIsActive[pixel] = 0;
                if (mRays.mOnly && !mRays.mOnly[pixel]) continue;
                mRays.mTubes.add(mRays.mRays.at(x, y), mRays.surfaceDepth(pixel), x - begin, packet);
            }
            std::vector<SeenTube> seen[kLanes];
            SeenTubes tubes[TubeCaster::kMostTubes];
            while (const int count = mRays.mTubes.next(packet, tubes)) {
                for (int i = 0; i < count; ++i) {
                    for (int lane = 0; lane < kLanes; ++lane) {
                        if (tubes[i].isSeen[lane]) seen[lane].push_back(tubes[i].lane(lane));
                    }
                }
            }
            for (int x = begin; x < end; ++x) {
                const std::size_t pixel = row + std::size_t(x);
                if (mRays.mOnly && !mRays.mOnly[pixel]) continue;
                const std::size_t first = mSeen.size();
                const glm::vec3 gap = seenThrough(mRays.surfaceColor(pixel), background);
                for (const SeenTube& tube : seen[x - begin]) {
                    const glm::vec3 own = tube.color * mRays.mBrightness;
                    const glm::vec3 color = glm::mix(glm::mix(own, background, tube.far), gap, tube.gap);
                    mColors.push_back(glm::vec4(color, 1) * tube.alpha);
                    mSeen.push_back(tube);
                }
                mDivided.push_back({pixel, first, mSeen.size()});
                mRays.mBegins[pixel] = 0;
            }
        }

        void setPart(const Divided& ray)
        {
            mRays.mIsActive[ray.pixel] = ray.isOver ? 0 : 1;
            mRays.mEnds[ray.pixel] = ray.next < ray.last ? mSeen[ray.next].depth : float(mRays.surfaceDepth(ray.pixel));
        }

        static PixelLayers layersOf(const SeenTube& tube)
        {
            return {.depth = tube.depth,
                    .normal = tube.normal,
                    .driver = tube.driver,
                    .texture = tube.texture,
                    .samples = 1};
        }

        DividedRays& mRays;
        std::vector<SeenTube> mSeen;
        std::vector<glm::vec4> mColors; // of the tubes, premultiplied
        std::vector<Divided> mDivided;  // by pixel
    };

  private:
    [[nodiscard]] double surfaceDepth(std::size_t pixel) const
    {
        return mSurfaces ? double(mSurfaces->depths[pixel]) : std::numeric_limits<double>::infinity();
    }

    [[nodiscard]] glm::vec4 surfaceColor(std::size_t pixel) const
    {
        return mSurfaces ? mSurfaces->colors[pixel] : glm::vec4(0);
    }

    TubeCaster mTubes;
    PixelRays mRays;
    PictureArea mArea;
    int mWidth;
    float mBrightness, mLeastTransmittance;
    const SurfacePicture* mSurfaces;
    const std::uint8_t* mOnly;
    std::vector<float> mBegins, mEnds; // of the parts that are cast now
    std::vector<std::uint8_t> mIsActive;
};

} // namespace vdblic
