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
std::vector<std::string> creationMetadata()
{
    // Not every file_*: Mantaflow's file_base_resolution, for example, describes the content.
    return {"creator",        "file_bbox_min",    "file_bbox_max",     "file_compression",
            "file_mem_bytes", "file_voxel_count", "file_delayed_load", "is_saved_as_half_float"};
}

Parameters parametersOf(CompareParams& params)
{
    const Limits positive{.least = 0, .most = 1e300};
    const auto addIgnored = [&params](const Words& names) {
        params.ignoredMetadata.insert(params.ignoredMetadata.end(), names.begin(), names.end());
    };
    Parameter ignored = parameter(
        "ignore_metadata",
        "Names of metadata to ignore besides creation details and file statistics; a last * stands for any rest.",
        WordType::kText, 1, addIgnored, [] { return Words{}; }, {.words = "NAME,NAME"});
    ignored.most = WordsOf<std::vector<std::string>>::kMost;
    return {
        parameter("fail", "Errors up to this are within tolerance.", params.fail,
                  {.unit = "unit of the values", .limits = positive}),
        parameter("relative", "Errors up to this share of the larger of |a| and |b| are within tolerance, too.",
                  params.relative, {.limits = positive}),
        parameter("fail_percent", "Share of a grid's voxels that may be over tolerance.", params.failPercent,
                  {.unit = "%", .limits = {0, 100}}),
        parameter("inactive", "Also compare inactive voxels that differ from the background.", params.inactive),
        ignored,
    };
}

void CompareParams::validate() const
{
    CompareParams copy = *this;
    checkLimits(parametersOf(copy));
    if (!(transformTolerance >= 0) || std::isinf(transformTolerance))
        throw ParameterError(
            fmt::format("the transform tolerance is {}; give a number of at least 0", transformTolerance));
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
