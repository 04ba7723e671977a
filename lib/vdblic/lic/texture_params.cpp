#include "vdblic/lic/texture_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

namespace vdblic {

void TextureParams::validate() const
{
    constexpr int kMaxLifeSpan = 1000;
    if (lifeSpan < 1 || lifeSpan > kMaxLifeSpan) {
        throw ParameterError(fmt::format("life span {} must lie between 1 and {} frames", lifeSpan, kMaxLifeSpan));
    }
    constexpr int kMaxSubsteps = 64;
    if (substeps < 1 || substeps > kMaxSubsteps) {
        throw ParameterError(fmt::format("substeps {} must lie between 1 and {}", substeps, kMaxSubsteps));
    }
    if (!(releaseWindow > 0 && releaseWindow <= 1)) {
        throw ParameterError(fmt::format("release window {} must be above 0 and at most 1 frame", releaseWindow));
    }
    pathline.validate();
    feedback.validate();
}

} // namespace vdblic
