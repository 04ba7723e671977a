#include "vdblic/field/derived_grids.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/index_axes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Mat3d;
using openvdb::Vec3d;
using openvdb::Vec3f;

/// The derivatives of the stored values along the index axes, as columns.
Mat3d indexGradient(const openvdb::Vec3SGrid::ConstAccessor& velocities, const Coord& at)
{
    const Vec3f here = velocities.getValue(at);
    Mat3d gradient;
    for (int axis = 0; axis < 3; ++axis) {
        Coord next = at, last = at;
        ++next[axis];
        --last[axis];
        Vec3f after, before;
        const bool hasAfter = velocities.probeValue(next, after), hasBefore = velocities.probeValue(last, before);
        Vec3d slope(0);
        if (hasAfter || hasBefore) slope = Vec3d(hasAfter ? after : here) - Vec3d(hasBefore ? before : here);
        gradient.setCol(axis, hasAfter && hasBefore ? slope * 0.5 : slope);
    }
    return gradient;
}

float vorticity(const Mat3d& j)
{
    return float(Vec3d(j(2, 1) - j(1, 2), j(0, 2) - j(2, 0), j(1, 0) - j(0, 1)).length());
}

float qCriterion(const Mat3d& j)
{
    return float(-0.5 * (j * j).trace());
}

} // namespace

void checkDerivedNames(const std::vector<std::string>& names)
{
    for (auto name = names.begin(); name != names.end(); ++name) {
        if (std::find(std::begin(kDerivedNames), std::end(kDerivedNames), *name) == std::end(kDerivedNames)) {
            throw ParameterError(
                fmt::format("no grid '{}' can be made beside the texture; known are {}, velocity and hits", *name,
                            fmt::join(kDerivedNames, ", ")));
        }
        if (std::find(names.begin(), name, *name) != name) {
            throw ParameterError(fmt::format("'{}' is asked for twice", *name));
        }
    }
}

std::vector<openvdb::FloatGrid::Ptr> derivedGrids(const std::vector<std::string>& names, const Domain& domain,
                                                  const openvdb::Vec3SGrid& velocities,
                                                  const FromStored<Space::kWorld, Per::kSecond>& unit)
{
    checkDerivedNames(names);
    const Mat3d toIndex = indexAxes(velocities.transform()).inverse();
    std::vector<openvdb::FloatGrid::Ptr> grids;
    for (const std::string& name : names) {
        const auto quantity = name == "q" ? &qCriterion : &vorticity;
        LeafValues<float> values(domain, 0.0f);
        forLeaves(domain.local(), [&](std::size_t leaf) {
            const openvdb::Vec3SGrid::ConstAccessor accessor = velocities.getConstAccessor();
            for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel) {
                const Coord at = domain.origin(leaf) + Domain::Leaf::offsetToLocalCoord(voxel.pos());
                values[leaf][voxel.pos()] = quantity(unit.matrix * indexGradient(accessor, at) * toIndex);
            }
        });
        grids.push_back(openvdb::FloatGrid::create(values.tree()));
        grids.back()->setName(name);
        grids.back()->setTransform(velocities.transform().copy());
        grids.back()->setGridClass(openvdb::GRID_FOG_VOLUME);
    }
    return grids;
}

} // namespace vdblic
