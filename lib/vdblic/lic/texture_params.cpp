#include "vdblic/lic/texture_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

namespace vdblic {

Parameters parametersOf(TextureParams& params)
{
    const Parameters own = {
        parameter(
            "method",
            "auflic: accelerated UFLIC; auflic-2004: the same as published; uflic: a seed for every voxel and "
            "frame; lic: each frame on its own; streaks: sparse, with a head and a tail; ibfv: the texture before, "
            "pulled back and blended with noise; lea: moved noise, blended from frame to frame; ufac: moved noise, "
            "convolved along the streamlines of each frame.",
            params.method, {.words = "METHOD", .group = "Texture"}),
        parameter("life_span", "Life span of a seed, with lic and ufac the length of the kernel.", params.lifeSpan,
                  {.option = "--life", .unit = "frames", .group = "Texture", .limits = {1, 1000}}),
        parameter("substeps", "Textures for each interval between frames.", params.substeps,
                  {.group = "Texture", .limits = {1, 64}}),
        parameter("release_window", "auflic, auflic-2004: part of a frame in which a pathline takes up seeds.",
                  params.releaseWindow, {.group = "Texture", .limits = {0, 1, true}, .isExpert = true}),
    };
    return joined({own, parametersOf(params.pathline), parametersOf(params.feedback)});
}

void TextureParams::validate() const
{
    TextureParams copy = *this;
    checkLimits(parametersOf(copy));
    feedback.validate();
}

} // namespace vdblic
