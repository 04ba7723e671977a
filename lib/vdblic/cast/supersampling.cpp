#include "vdblic/cast/supersampling.h"

#include "vdblic/camera/camera.h"
#include "vdblic/cast/ray_setup.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <stop_token>
#include <utility>

namespace vdblic {
namespace {

/// Turn the layers of one sample into sums.
void weighLayers(Image& image)
{
    for (std::size_t i = 0; i < image.layers.size(); ++i) {
        const PixelLayers sample = image.layers[i];
        image.layers[i] = {.depth = 0};
        addLayers(image.layers[i], sample, image.pixels[i].a);
    }
}

constexpr int kRaysOfAll = 2;
using Pixels = tbb::blocked_range<std::size_t>;

/// A pixel as it is seen: in about even steps.
glm::vec4 seen(const glm::vec4& pixel)
{
    return glm::sqrt(glm::max(pixel, glm::vec4(0)));
}

bool differ(const glm::vec4& a, const glm::vec4& b)
{
    constexpr float kMost = 1 / 20.0f;
    const glm::vec4 difference = glm::abs(a - b);
    return std::max({difference.r, difference.g, difference.b, difference.a}) > kMost;
}

/// The pixels of an image that need further rays. @param first image of the first ray  @param sum of the first two
std::vector<std::uint8_t> pixelsToRefine(const Image& first, const Image& sum, const PictureArea& area)
{
    std::vector<std::uint8_t> result(sum.pixels.size());
    constexpr int kTile = RaySetup::kTile;
    const glm::ivec2 tiles = (area.high - area.low + kTile - 1) / kTile;
    tbb::parallel_for(0, tiles.x * tiles.y, [&](int tile) {
        const glm::ivec2 low = area.low + glm::ivec2(tile % tiles.x, tile / tiles.x) * kTile;
        const glm::ivec2 high = glm::min(low + kTile, area.high);
        const auto index = [&](int x, int y) { return std::size_t(y) * std::size_t(sum.size.x) + std::size_t(x); };
        glm::vec4 means[kTile][kTile];
        for (int y = low.y; y < high.y; ++y) {
            for (int x = low.x; x < high.x; ++x) {
                const std::size_t i = index(x, y);
                means[y - low.y][x - low.x] = seen(sum.pixels[i] * 0.5f);
                result[i] = differ(seen(first.pixels[i]), seen(sum.pixels[i] - first.pixels[i]));
            }
        }
        const auto compare = [&](int x, int y, int nextX, int nextY) {
            if (nextX < low.x || nextX >= high.x || nextY >= high.y) return;
            if (!differ(means[y - low.y][x - low.x], means[nextY - low.y][nextX - low.x])) return;
            result[index(x, y)] = 1;
            result[index(nextX, nextY)] = 1;
        };
        for (int y = low.y; y < high.y; ++y) {
            for (int x = low.x; x < high.x; ++x) {
                compare(x, y, x + 1, y);
                for (const int across : {-1, 0, 1})
                    compare(x, y, x + across, y + 1);
            }
        }
    });
    return result;
}

} // namespace

void addLayers(PixelLayers& sum, const PixelLayers& layers, float alpha)
{
    sum.samples += layers.samples;
    if (!(alpha > 0)) return;
    sum.depth += alpha * layers.depth;
    sum.normal += alpha * layers.normal;
    sum.driver += alpha * layers.driver;
    sum.texture += alpha * layers.texture;
}

void divideLayers(PixelLayers& sum, float alpha)
{
    if (!(alpha > 0)) {
        sum = {.samples = sum.samples};
        return;
    }
    sum.depth /= alpha;
    sum.driver /= alpha;
    sum.texture /= alpha;
    if (const float length = glm::length(sum.normal); length > 0) sum.normal /= length;
}

void SampleSum::add(const std::stop_token& stop)
{
    constexpr glm::dvec2 kStep(0.7548776662466927, 0.5698402909980532); // inverse powers of the plastic number
    const glm::dvec2 offset = glm::fract(0.5 + double(mCount) * kStep) - 0.5;
    const std::uint8_t* const only = mCount < kRaysOfAll ? nullptr : mRefined.data();
    Image image = mCast(mCamera.shifted(offset), mCount, only, stop);
    if (mCount++ == 0) {
        mFirst = {image.size, image.pixels};
        mSum = std::move(image);
        return;
    }
    if (mCount == 2) weighLayers(mSum);
    tbb::parallel_for(Pixels(0, mSum.pixels.size()), [&](const Pixels& pixels) {
        for (std::size_t i = pixels.begin(); i < pixels.end(); ++i) {
            if (!image.layers.empty()) addLayers(mSum.layers[i], image.layers[i], image.pixels[i].a);
            mSum.pixels[i] += image.pixels[i];
        }
    });
    if (mCount != kRaysOfAll) return;
    // Two points of a lens do not represent the others.
    mRefined = mCamera.lens() ? std::vector<std::uint8_t>(mSum.pixels.size(), 1)
                              : pixelsToRefine(mFirst, mSum, mCamera.area());
    mFirst = {};
}

Image SampleSum::mean() const
{
    Image result = mSum;
    if (mCount == 1) return result;
    tbb::parallel_for(Pixels(0, result.pixels.size()), [&](const Pixels& pixels) {
        for (std::size_t i = pixels.begin(); i < pixels.end(); ++i) {
            if (!result.layers.empty()) divideLayers(result.layers[i], result.pixels[i].a);
            const int rays = mCount <= kRaysOfAll || mRefined[i] ? mCount : kRaysOfAll;
            result.pixels[i] /= float(rays);
        }
    });
    return result;
}

} // namespace vdblic
