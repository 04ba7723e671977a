#include "vdblic/cast/ground_params.h"

#include "vdblic/image/vector_text.h"

namespace vdblic {

Parameters parametersOf(GroundParams& params)
{
    return {
        parameter("ground",
                  "Plane below the domain, or along one of its walls, that takes the shadows of volume and solid and "
                  "fades into the background; seen from the domain's side alone.",
                  params.side, {.words = "SIDE", .group = "Solid"}),
        parameter("ground_color",
                  "Colour of the ground as displayed; by default that of the background, or a lighter "
                  "one where the background is too dark for shadows.",
                  params.color, {.words = "R G B", .group = "Solid", .limits = {0, 1}}),
    };
}

void GroundParams::validate() const
{
    GroundParams copy = *this;
    checkLimits(parametersOf(copy));
}

} // namespace vdblic
