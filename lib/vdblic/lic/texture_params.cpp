#include "vdblic/lic/texture_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

namespace vdblic {

Parameters parametersOf(TextureParams& params)
{
    const Parameters own = {
        parameter({.key = "method",
                   .text = "auflic: accelerated UFLIC; auflic-2004: the same as published; uflic: a seed for every "
                           "voxel and frame; lic: each frame on its own.",
                   .words = "METHOD",
                   .group = "Texture"},
                  params.method),
        parameter({.key = "life_span",
                   .text = "Life span of a seed, with lic the length of the kernel.",
                   .option = "--life",
                   .unit = "frames",
                   .group = "Texture",
                   .limits = {1, 1000}},
                  params.lifeSpan),
        parameter({.key = "substeps",
                   .text = "Textures for each interval between frames.",
                   .group = "Texture",
                   .limits = {1, 64}},
                  params.substeps),
        parameter({.key = "release_window",
                   .text = "auflic, auflic-2004: part of a frame in which a pathline takes up seeds.",
                   .group = "Texture",
                   .limits = {0, 1, true},
                   .isExpert = true},
                  params.releaseWindow),
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
