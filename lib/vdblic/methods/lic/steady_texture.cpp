#include "vdblic/methods/lic/steady_texture.h"

#include "vdblic/lic/path_reach.h"
#include "vdblic/lic/streamline_convolution.h"
#include "vdblic/noise/noise.h"

#include <cstddef>
#include <utility>

namespace vdblic {

SteadyTexture::SteadyTexture(const TextureParams& params, NoiseField noise) : mParams(params), mNoise(std::move(noise))
{
}

TextureFrame SteadyTexture::advance(const FlowStep& step)
{
    StageClock clock;
    TextureFrame result(step);
    if (step.isShown) {
        const auto stage = clock.enter(&StageTimes::convolve);
        const Domain& domain = *step.start.domain.texture;
        const StreamlineConvolution convolution{step, mParams.kernelHalf(), mParams.pathline};
        result.texture = convolution(noiseValues(domain, mNoise, domain.local()), kNoiseMax, clock);
    }
    result.times = clock.times();
    return result;
}

Lengths<Space::kTexture> SteadyTexture::farthestPath(const Speeds<Space::kTexture, Per::kFrame>& fastest,
                                                     double /*seconds*/) const
{
    Lengths<Space::kTexture> farthest;
    for (std::size_t axis = 0; axis < 3; ++axis)
        farthest.along[axis] = longestPath(0.5f * float(mParams.lifeSpan) * fastest[axis]);
    return farthest;
}

} // namespace vdblic
