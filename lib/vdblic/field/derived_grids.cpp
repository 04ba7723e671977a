#include "vdblic/field/derived_grids.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/index_axes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openvdb/openvdb.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Mat3d;
using openvdb::Vec3d;
using openvdb::Vec3f;

/// The derivatives of the stored values along the index axes, as columns.
Mat3d indexGradient(const openvdb::Vec3SGrid::ConstAccessor& velocities, const Coord& at, const Period& period = {})
{
    const Vec3f here = velocities.getValue(at);
    Mat3d gradient;
    for (int axis = 0; axis < 3; ++axis) {
        Coord next = at, last = at;
        ++next[axis];
        --last[axis];
        Vec3f after, before;
        const bool hasAfter = velocities.probeValue(period.wrapped(next), after),
                   hasBefore = velocities.probeValue(period.wrapped(last), before);
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
                values[leaf][voxel.pos()] =
                    quantity(unit.matrix * indexGradient(accessor, at, domain.period()) * toIndex);
            }
        });
        grids.push_back(openvdb::FloatGrid::create(values.tree()));
        grids.back()->setName(name);
        grids.back()->setTransform(velocities.transform().copy());
        grids.back()->setGridClass(openvdb::GRID_FOG_VOLUME);
    }
    return grids;
}

double rotationShare(const openvdb::Vec3SGrid& velocities, const FromStored<Space::kWorld, Per::kSecond>& unit)
{
    constexpr std::size_t kMostLeaves = 4096;
    constexpr double kRounding = 2e-3; // relative to the values: rounding of half precision
    struct Sums {
        double q = 0, gradient = 0, difference = 0, value = 0;
    };
    const Mat3d toIndex = indexAxes(velocities.transform()).inverse();
    const openvdb::tree::LeafManager<const openvdb::Vec3STree> leaves(velocities.tree());
    const std::size_t stride = (leaves.leafCount() + kMostLeaves - 1) / kMostLeaves;
    std::vector<Sums> sums(stride > 0 ? (leaves.leafCount() + stride - 1) / stride : 0);
    tbb::parallel_for(std::size_t(0), sums.size(), [&](std::size_t i) {
        const openvdb::Vec3SGrid::ConstAccessor accessor = velocities.getConstAccessor();
        for (auto value = leaves.leaf(i * stride).cbeginValueOn(); value; ++value) {
            const Mat3d difference = unit.matrix * indexGradient(accessor, value.getCoord()), j = difference * toIndex;
            sums[i].q += std::max(double(qCriterion(j)), 0.0);
            sums[i].gradient += 0.5 * (j * j.transpose()).trace();
            sums[i].difference += (difference * difference.transpose()).trace();
            sums[i].value += (unit.matrix * Vec3d(*value)).lengthSqr();
        }
    });
    Sums all;
    for (const Sums& one : sums)
        all = {all.q + one.q, all.gradient + one.gradient, all.difference + one.difference, all.value + one.value};
    return all.difference > kRounding * kRounding * all.value ? all.q / all.gradient : 0;
}

} // namespace vdblic
