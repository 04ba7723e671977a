#include "vdblic/cast/light_grid.h"

#include "vdblic/camera/camera.h"
#include "vdblic/cast/ambient_light.h"
#include "vdblic/cast/extinction_grid.h"
#include "vdblic/cast/optical_depths.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/texture_volume.h"

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include <cmath>
#include <cstddef>
#include <limits>

namespace vdblic {

glm::dvec3 keyLight(const Look& look, const Camera& camera)
{
    if (!look.shading.lights.empty()) return look.shading.lights.front().direction;
    const glm::dmat3 toWorld = glm::transpose(glm::dmat3(camera.worldToCamera()));
    return toWorld * glm::dvec3(-0.5, 0.8, -0.35);
}

LightGrid::LightGrid(const ExtinctionGrid& visible, const AmbientLight& ambient, const TextureVolume& volume,
                     const Look& look, const glm::dvec3& towardsLight)
    : mCell(visible.cell()), mCells(visible.origin(), visible.dim(), mCell), mFactors(ambient.factors())
{
    if (!(look.shadows > 0)) return;
    constexpr double kWithoutEnd = std::numeric_limits<double>::infinity();
    const glm::dmat3 toIndex(volume.worldToIndex());
    const std::vector<float> depths =
        opticalDepths(visible, ambient.extinctions(), toIndex * towardsLight, kWithoutEnd, true);
    const auto strength = double(look.shadows);
    for (std::size_t cell = 0; cell < depths.size(); ++cell)
        mFactors[cell] *= float(1 - strength * (1 - std::exp(-double(depths[cell]))));
}

float LightGrid::at(const glm::dvec3& position) const
{
    const Float8 all[] = {broadcast8(float(position.x)), broadcast8(float(position.y)), broadcast8(float(position.z))};
    return at(all)[0];
}

} // namespace vdblic
