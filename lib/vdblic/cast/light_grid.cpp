#include "vdblic/cast/light_grid.h"

#include "vdblic/camera/camera.h"
#include "vdblic/cast/extinction_grid.h"
#include "vdblic/cast/optical_depths.h"
#include "vdblic/cast/solid.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/placed_box.h"

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace vdblic {
namespace {

constexpr float kSolidExtinction = 10; // per voxel

} // namespace

glm::dvec3 keyLight(const Look& look, const Camera& camera)
{
    if (!look.shading.lights.empty()) return look.shading.lights.front().direction;
    const glm::dmat3 toWorld = glm::transpose(glm::dmat3(camera.worldToCamera()));
    return toWorld * glm::dvec3(-0.5, 0.8, -0.35);
}

LightGrid::LightGrid(const ExtinctionGrid& visible, const AmbientLight& ambient, const PlacedBox& box, const Look& look,
                     const glm::dvec3& towardsLight)
    : mCell(visible.cell()), mCells(visible.origin(), visible.dim(), mCell), mFactors(ambient.factors())
{
    if (!(look.shadows > 0)) return;
    constexpr double kWithoutEnd = std::numeric_limits<double>::infinity();
    const glm::dmat3 toIndex(box.worldToIndex());
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

AmbientLight::AmbientLight(const ExtinctionGrid& visible, const PlacedBox& box, const Look& look, const Solid* solid)
    : mExtinctions(visible.values()), mFactors(mExtinctions.size(), 1)
{
    if (solid) addSolid(box, *solid, visible);
    if (look.occlusion > 0) occlude(visible, double(look.occlusion));
}

void AmbientLight::addSolid(const PlacedBox& box, const Solid& solid, const ExtinctionGrid& grid)
{
    const openvdb::Coord &origin = grid.origin(), &dim = grid.dim();
    const glm::dmat4 toSolid = solid.worldToIndex * box.indexToWorld();
    tbb::parallel_for(0, dim[0], [&](int x) {
        const auto values = solid.levelSet->getConstAccessor();
        for (int y = 0; y < dim[1]; ++y) {
            for (int z = 0; z < dim[2]; ++z) {
                const glm::dvec3 cell(x + 0.5, y + 0.5, z + 0.5);
                const glm::dvec3 middle =
                    glm::dvec3(origin[0], origin[1], origin[2]) + cell * double(grid.cell()) - 0.5;
                const glm::dvec4 at = toSolid * glm::dvec4(middle, 1);
                if (values.getValue(openvdb::Coord::round(openvdb::Vec3d(at.x, at.y, at.z))) < 0)
                    mExtinctions[grid.index({x, y, z})] = kSolidExtinction;
            }
        }
    });
}

/// Set the factors of ambient occlusion.
void AmbientLight::occlude(const ExtinctionGrid& grid, double strength)
{
    constexpr float kGain = 2;         // on optical depths: visible matter is mostly half transparent
    constexpr double kReach = 1 / 8.0; // share of the grid's mean edge within which cells occlude
    constexpr double kAlongAxis = 1 / 15.0, kAcross = 3 / 40.0, kMostFactor = 1.6;
    const double reach = kReach * grid.cell() * std::cbrt(double(mExtinctions.size()));
    std::vector<float> arriving(mExtinctions.size());
    for (int i = 0; i < 27; ++i) {
        const glm::dvec3 direction(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1);
        const double square = glm::dot(direction, direction);
        if (square != 1 && square != 3) continue;
        const double weight = square == 1 ? kAlongAxis : kAcross;
        const std::vector<float> depths = opticalDepths(grid, mExtinctions, direction, reach, false);
        tbb::parallel_for(std::size_t(0), arriving.size(),
                          [&](std::size_t cell) { arriving[cell] += float(weight) * std::exp(-kGain * depths[cell]); });
    }
    double sum = 0, seen = 0; // enclosed cells are hardly seen
    for (std::size_t cell = 0; cell < arriving.size(); ++cell) {
        const double visible = -std::expm1(-double(mExtinctions[cell]) * grid.cell());
        seen += visible * double(arriving[cell]);
        sum += visible * double(arriving[cell]) * double(arriving[cell]);
    }
    const double perMean = sum > 0 ? seen / sum : 1;
    for (std::size_t cell = 0; cell < arriving.size(); ++cell) {
        const double relative = std::min(double(arriving[cell]) * perMean, kMostFactor);
        mFactors[cell] = float(1 + strength * (relative - 1));
    }
}

} // namespace vdblic
