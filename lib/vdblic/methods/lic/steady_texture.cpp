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

FlowTextureStep SteadyTexture::advance(const FlowStep& step)
{
    StageClock clock;
    FlowTextureStep result;
    const FlowFrame& frame = step.start;
    if (step.isShown) {
        const auto stage = clock.enter(&StageTimes::convolve);
        const StreamlineConvolution convolution{frame, step.startToStep, mParams.kernelHalf(), mParams.pathline};
        result.texture = convolution(noiseValues(*frame.domain, mNoise, frame.domain->local()), kNoiseMax, clock);
    }
    result.times = clock.times();
    result.domain = frame.domain;
    result.refinement = frame.refinement;
    return result;
}

std::array<float, 3> SteadyTexture::farthestPath(const std::array<float, 3>& displacement, double /*interval*/) const
{
    std::array<float, 3> farthest{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        farthest[axis] = longestPath(0.5f * float(mParams.lifeSpan) * displacement[axis]);
    return farthest;
}

} // namespace vdblic
