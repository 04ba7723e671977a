#include "vdblic/cast/supersampling.h"

#include "vdblic/camera/camera.h"
#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/ray_caster.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/texture_volume.h"
#include "vdblic/volume/visible_leaves.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <cstddef>
#include <stop_token>
#include <utility>

namespace vdblic {
namespace {

/// Add a sample's layers, weighted by its alpha, to a pixel's sums.
void addLayers(PixelLayers& sum, const PixelLayers& sample, float alpha)
{
    sum.samples += sample.samples;
    if (!(alpha > 0)) return;
    sum.depth += alpha * sample.depth;
    sum.normal += alpha * sample.normal;
    sum.driver += alpha * sample.driver;
    sum.texture += alpha * sample.texture;
}

/// Turn the layers of one sample into sums.
void weighLayers(Image& image)
{
    for (std::size_t i = 0; i < image.layers.size(); ++i) {
        const PixelLayers sample = image.layers[i];
        image.layers[i] = {.depth = 0};
        addLayers(image.layers[i], sample, image.pixels[i].a);
    }
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

} // namespace

SampleSum::SampleSum(const TextureVolume& volume, const Look& look, const Camera& camera, const RayCastParams& params,
                     const Scenery& scenery)
    : mVolume(volume), mLook(look), mCamera(camera), mParams(params), mScenery(scenery), mVisible(volume, look)
{
}

void SampleSum::add(const std::stop_token& stop)
{
    constexpr glm::dvec2 kStep(0.7548776662466927, 0.5698402909980532); // inverse powers of the plastic number
    const glm::dvec2 offset = glm::fract(0.5 + double(mCount) * kStep) - 0.5;
    Image image = castRays(mVolume, mLook, mCamera.shifted(offset), mParams, mVisible, mCount, mScenery, stop);
    if (mCount++ == 0) {
        mSum = std::move(image);
        return;
    }
    if (mCount == 2) weighLayers(mSum);
    for (std::size_t i = 0; i < mSum.pixels.size(); ++i) {
        if (mParams.layers) addLayers(mSum.layers[i], image.layers[i], image.pixels[i].a);
        mSum.pixels[i] += image.pixels[i];
    }
}

Image SampleSum::mean() const
{
    Image result = mSum;
    if (mCount == 1) return result;
    for (std::size_t i = 0; i < result.pixels.size(); ++i) {
        if (mParams.layers) divideLayers(result.layers[i], result.pixels[i].a);
        result.pixels[i] /= float(mCount);
    }
    return result;
}

Image castSamples(const TextureVolume& volume, const Look& look, const Camera& camera, const RayCastParams& params,
                  int samples, const Scenery& scenery)
{
    SampleSum sum(volume, look, camera, params, scenery);
    for (int sample = 0; sample < samples; ++sample)
        sum.add();
    return sum.mean();
}

} // namespace vdblic
