#include "vdblic/render/supersampling.h"

#include "vdblic/render/camera.h"
#include "vdblic/render/look.h"
#include "vdblic/render/ray_cast_params.h"
#include "vdblic/render/ray_caster.h"
#include "vdblic/render/texture_volume.h"
#include "vdblic/render/visible_leaves.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <cstddef>
#include <vector>

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

Image castSamples(const TextureVolume& volume, const Look& look, const Camera& camera, const RayCastParams& params,
                  int samples, const Scenery& scenery)
{
    const VisibleLeaves visible(volume, look);
    if (samples == 1) return castRays(volume, look, camera, params, visible, 0, scenery);
    constexpr glm::dvec2 kStep(0.7548776662466927, 0.5698402909980532); // inverse powers of the plastic number
    Image sum{camera.size(), std::vector<glm::vec4>(std::size_t(camera.size().x) * camera.size().y, glm::vec4(0))};
    if (params.layers) sum.layers.assign(sum.pixels.size(), {.depth = 0});
    for (int sample = 0; sample < samples; ++sample) {
        const glm::dvec2 offset = glm::fract(0.5 + double(sample) * kStep) - 0.5;
        const Image image = castRays(volume, look, camera.shifted(offset), params, visible, sample, scenery);
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
