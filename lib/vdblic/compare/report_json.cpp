#include "vdblic/compare/report.h"

#include "vdblic/io/json_file.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <optional>

namespace vdblic {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value)
{
    if (std::isnan(value)) return "nan";
    if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
    return value;
}

Json numbers(const std::array<double, 3>& values)
{
    return {number(values[0]), number(values[1]), number(values[2])};
}

template<typename T>
Json orNull(const std::optional<T>& value)
{
    return value ? Json(*value) : Json(nullptr);
}

Json textOrNull(const std::string& text)
{
    return text.empty() ? Json(nullptr) : Json(text);
}

template<typename Items, typename Convert>
Json list(const Items& items, const Convert& convert)
{
    Json result = Json::array();
    for (const auto& item : items)
        result.push_back(convert(item));
    return result;
}

Json ofErrors(const ErrorFigures& error)
{
    return {{"max", number(error.max)}, {"mean", number(error.mean)}, {"rms", number(error.rms)}};
}

Json ofVoxel(const std::optional<VoxelDifference>& voxel)
{
    if (!voxel) return nullptr;
    return {{"index", voxel->index},
            {"world", numbers(voxel->world)},
            {"a", voxel->a},
            {"b", voxel->b},
            {"active_in_a", voxel->activeInA},
            {"active_in_b", voxel->activeInB},
            {"error", number(voxel->error)}};
}

Json ofValues(const ValueDifference& values)
{
    return {{"verdict", toText(values.verdict)},
            {"compared", values.compared},
            {"failing", values.failing},
            {"failing_percent", number(values.failingPercent())},
            {"over_fail", values.overFail},
            {"only_in_a", values.onlyInA},
            {"only_in_b", values.onlyInB},
            {"not_finite", values.notFinite},
            {"error", ofErrors(values.error)},
            {"components", list(values.components, ofErrors)},
            {"max_relative", number(values.maxRelative)},
            {"peak", number(values.peak)},
            {"psnr", number(values.psnr)},
            {"first", ofVoxel(values.first)},
            {"worst", ofVoxel(values.worst)}};
}

Json ofMetadata(const MetadataDifference& item)
{
    return {{"key", item.key}, {"a", orNull(item.a)}, {"b", orNull(item.b)}};
}

Json ofAttribute(const AttributeDifference& attribute)
{
    return {{"name", attribute.name},
            {"verdict", toText(attribute.verdict())},
            {"type_a", textOrNull(attribute.typeA)},
            {"type_b", textOrNull(attribute.typeB)},
            {"values", attribute.values ? ofValues(*attribute.values) : Json(nullptr)}};
}

Json ofPoints(const PointDifference& points)
{
    return {{"verdict", toText(points.verdict())},
            {"count_a", points.countA},
            {"count_b", points.countB},
            {"matched_by", points.matchedById ? "id" : "voxel"},
            {"matched", points.matched},
            {"only_in_a", points.onlyInA},
            {"only_in_b", points.onlyInB},
            {"attributes", list(points.attributes, ofAttribute)}};
}

Json ofGrid(const GridDifference& grid)
{
    Json result = {{"name", grid.name},
                   {"occurrence", grid.occurrence},
                   {"verdict", toText(grid.verdict())},
                   {"type_a", textOrNull(grid.typeA)},
                   {"type_b", textOrNull(grid.typeB)},
                   {"transform", nullptr},
                   {"background", nullptr},
                   {"metadata", list(grid.metadata, ofMetadata)},
                   {"values", grid.values ? ofValues(*grid.values) : Json(nullptr)},
                   {"points", grid.points ? ofPoints(*grid.points) : Json(nullptr)}};
    if (grid.transform) {
        result["transform"] = {
            {"a", grid.transform->a}, {"b", grid.transform->b}, {"shift_voxels", number(grid.transform->shift)}};
    }
    if (grid.background) result["background"] = {{"a", grid.background->a}, {"b", grid.background->b}};
    return result;
}

Json ofFrame(const FrameDifference& frame)
{
    return {{"frame", frame.frame},
            {"verdict", toText(frame.verdict())},
            {"a", frame.inA ? Json(frame.files.pathA) : Json(nullptr)},
            {"b", frame.inB ? Json(frame.files.pathB) : Json(nullptr)},
            {"metadata", list(frame.files.metadata, ofMetadata)},
            {"grids", list(frame.files.grids, ofGrid)}};
}

Json ofParams(const CompareParams& params)
{
    return {{"fail", params.fail},
            {"relative", params.relative},
            {"fail_percent", params.failPercent},
            {"inactive", params.inactive},
            {"transform_tolerance_voxels", params.transformTolerance},
            {"ignored_metadata", params.ignoredMetadata}};
}

} // namespace

std::string toJson(const SequenceDifference& difference, const CompareParams& params)
{
    const Json report = {{"verdict", toText(difference.verdict())},
                         {"a", difference.a},
                         {"b", difference.b},
                         {"parameters", ofParams(params)},
                         {"frames", list(difference.frames, ofFrame)}};
    return jsonText(report);
}

} // namespace vdblic
