#include "vdblic/compare/compare.h"

#include "vdblic/compare/grid_types.h"
#include "vdblic/compare/metadata_difference.h"
#include "vdblic/compare/point_difference.h"
#include "vdblic/compare/tree_difference.h"
#include "vdblic/core/errors.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>

#include <cmath>
#include <type_traits>

namespace vdblic {
namespace {

void checkTolerance(const char* name, double value)
{
    if (!(value >= 0) || std::isinf(value)) {
        throw ParameterError(fmt::format("{} is {}; give a number of at least 0", name, value));
    }
}

} // namespace

std::vector<std::string> creationMetadata()
{
    // Not every file_*: Mantaflow's file_base_resolution, for example, describes the content.
    return {"creator",        "file_bbox_min",    "file_bbox_max",     "file_compression",
            "file_mem_bytes", "file_voxel_count", "file_delayed_load", "is_saved_as_half_float"};
}

void CompareParams::validate() const
{
    checkTolerance("the failure tolerance (`fail`)", fail);
    checkTolerance("the relative tolerance (`relative`)", relative);
    checkTolerance("the share of failures (`fail_percent`)", failPercent);
    if (failPercent > 100) {
        throw ParameterError(fmt::format("the share of failures (`fail_percent`) is {}; at most 100", failPercent));
    }
    if (hardFail) checkTolerance("the hard limit (`hard_fail`)", *hardFail);
    if (warn) checkTolerance("the warning tolerance (`warn`)", *warn);
    checkTolerance("the transform tolerance", transformTolerance);
    if (firstOnly && failPercent > 0) {
        throw ParameterError(
            "`first` stops before the share of failures is known; leave out `fail_percent` or `first`");
    }
}

GridDifference compareGrids(const openvdb::GridBase& a, const openvdb::GridBase& b, const CompareParams& params)
{
    params.validate();
    GridDifference result;
    result.name = a.getName();
    result.typeA = a.valueType();
    result.typeB = b.valueType();
    result.metadata = compare::compareMetadata(a, b, params.ignoredMetadata);
    result.transform = compare::compareTransforms(a, b, params.transformTolerance);
    // A value type identifies the grid type here: OpenVDB reads one tree configuration of each.
    if (a.type() != b.type()) {
        if (result.typeA == result.typeB) {
            result.typeA = a.type();
            result.typeB = b.type();
        }
        return result;
    }
    if (params.firstOnly && result.verdict() == Verdict::kDiffers) return result;

    using openvdb::points::PointDataGrid;
    if (a.isType<PointDataGrid>()) {
        result.points =
            compare::comparePoints(static_cast<const PointDataGrid&>(a), static_cast<const PointDataGrid&>(b), params);
        return result;
    }
    const bool known = a.apply<compare::GridTypes>([&](const auto& grid) {
        using Grid = std::decay_t<decltype(grid)>;
        compare::compareTrees(grid, static_cast<const Grid&>(b), params, result);
    });
    if (!known) {
        throw InputError(fmt::format("grid '{}' is of type {}, which cannot be compared; float, double, int32, int64, "
                                     "bool, mask, vec3 and points can",
                                     result.name, a.type()));
    }
    return result;
}

} // namespace vdblic
