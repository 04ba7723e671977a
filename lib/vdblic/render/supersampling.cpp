#include "vdblic/render/supersampling.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace vdblic {
namespace {

/// Add a sample's layers, weighted by its alpha, to a pixel's sums.
void addLayers(PixelLayers& sum, const PixelLayers& sample, float alpha)
{
    sum.samples += sample.samples;
    if (!(alpha > 0)) return;
    sum.depth += alpha * sample.depth;
    sum.normal += alpha * sample.normal;
    sum.magnitude += alpha * sample.magnitude;
    sum.texture += alpha * sample.texture;
}

void divideLayers(PixelLayers& sum, float alpha)
{
    if (!(alpha > 0)) {
        sum = {.samples = sum.samples};
        return;
    }
    sum.depth /= alpha;
    sum.magnitude /= alpha;
    sum.texture /= alpha;
    if (const float length = glm::length(sum.normal); length > 0) sum.normal /= length;
}

} // namespace

Image castSamples(const TextureVolume& volume, const Look& look, const Camera& camera, const RayCastParams& params,
                  int samples)
{
    const VisibleLeaves visible(volume, look);
    if (samples == 1) return castRays(volume, look, camera, params, visible);
    constexpr glm::dvec2 kStep(0.7548776662466927, 0.5698402909980532); // inverse powers of the plastic number
    Image sum{camera.size(), std::vector<glm::vec4>(std::size_t(camera.size().x) * camera.size().y, glm::vec4(0))};
    if (params.layers) sum.layers.assign(sum.pixels.size(), {.depth = 0});
    for (int sample = 0; sample < samples; ++sample) {
        const glm::dvec2 place = glm::fract(0.5 + double(sample) * kStep) - 0.5;
        const Image image = castRays(volume, look, camera.shifted(place), params, visible, sample);
        for (std::size_t i = 0; i < sum.pixels.size(); ++i) {
            sum.pixels[i] += image.pixels[i];
            if (params.layers) addLayers(sum.layers[i], image.layers[i], image.pixels[i].a);
        }
    }
    for (std::size_t i = 0; i < sum.pixels.size(); ++i) {
        if (params.layers) divideLayers(sum.layers[i], sum.pixels[i].a);
        sum.pixels[i] /= float(samples);
    }
    return sum;
}

} // namespace vdblic
