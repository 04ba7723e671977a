#include "vdblic/methods/backward/backward_params.h"

#include <algorithm>
#include <cmath>

namespace vdblic {
namespace {

constexpr double kLeastShare = 0.01;

} // namespace

Parameters parametersOf(BackwardParams& params)
{
    return {
        parameter(
            "alpha",
            "ibfv, lea: share of the noise that is blended in with every frame: the smaller, the longer the streaks; "
            "by default 4 / (3 life), as long as those of auflic.",
            params.alpha, {.limits = {kLeastShare, 1}}),
    };
}

void BackwardParams::validate() const
{
    BackwardParams copy = *this;
    checkLimits(parametersOf(copy));
}

double BackwardParams::shareFor(int lifeSpan) const
{
    return alpha.value_or(std::clamp(4.0 / (3.0 * lifeSpan), kLeastShare, 1.0));
}

double BackwardParams::stepShare(int lifeSpan, int substeps) const
{
    constexpr double kMostShare = 0.999999;
    return -std::expm1(std::log1p(-std::min(shareFor(lifeSpan), kMostShare)) / substeps);
}

int BackwardParams::settlingFrames(int lifeSpan) const
{
    constexpr double kLeft = 0.2;
    const double share = shareFor(lifeSpan);
    return share < 1 ? std::max(int(std::ceil(std::log(kLeft) / std::log1p(-share))), 1) : 1;
}

} // namespace vdblic
