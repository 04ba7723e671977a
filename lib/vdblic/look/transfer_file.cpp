#include "vdblic/look/transfer_file.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/json_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace vdblic {
namespace {

using Json = nlohmann::json;

/// A list of rows of `count` numbers. @throws ParameterError
std::vector<std::vector<double>> rows(const Json& value, const std::string& key, std::size_t count)
{
    std::vector<std::vector<double>> result;
    const bool good =
        value.is_array() && !value.empty() && std::all_of(value.begin(), value.end(), [&](const Json& row) {
            return row.is_array() && row.size() == count &&
                   std::all_of(row.begin(), row.end(), [](const Json& number) { return number.is_number(); });
        });
    if (!good) throw ParameterError(fmt::format("'{}' must be a list of lists of {} numbers", key, count));
    for (const Json& row : value)
        result.push_back(row.get<std::vector<double>>());
    return result;
}

std::array<double, 2> parseRange(const Json& value, const std::string& key)
{
    const std::vector<double> range = rows(Json::array({value}), key, 2).front();
    return {range[0], range[1]};
}

std::string parseText(const Json& value, const std::string& key)
{
    if (!value.is_string()) throw ParameterError(fmt::format("'{}' must be text", key));
    return value.get<std::string>();
}

void readKey(const std::string& key, const Json& value, TransferParams& params)
{
    if (key == "range") {
        params.range = parseRange(value, key);
    } else if (key == "opacity_range") {
        params.opacityRange = parseRange(value, key);
    } else if (key == "unit") {
        params.unit = parseText(value, key);
    } else if (key == "opacity_unit") {
        params.opacityUnit = parseText(value, key);
    } else if (key == "color_scale") {
        params.colorScale = valueOf<ValueScale>(parseText(value, key));
    } else if (key == "opacity_scale") {
        params.opacityScale = valueOf<ValueScale>(parseText(value, key));
    } else if (key == "colormap") {
        params.colorMap = parseText(value, key);
        params.colors.clear();
    } else if (key == "colors") {
        params.colors.clear();
        for (const auto& row : rows(value, key, 4))
            params.colors.push_back({row[0], {row[1], row[2], row[3]}});
    } else if (key == "opacity") {
        params.opacity.clear();
        for (const auto& row : rows(value, key, 2))
            params.opacity.push_back({row[0], row[1]});
    } else {
        throw ParameterError(fmt::format("'{}' is none of range, unit, color_scale, colormap, colors, opacity, "
                                         "opacity_range, opacity_unit, opacity_scale",
                                         key));
    }
}

} // namespace

void readTransferFile(const std::filesystem::path& path, TransferParams& params)
{
    const Json file = readJson(path);
    try {
        if (!file.is_object()) throw ParameterError("it must be an object, {\"opacity\": ...}");
        if (file.contains("colormap") && file.contains("colors")) {
            throw ParameterError("'colormap' and 'colors' exclude each other");
        }
        for (const auto& [key, value] : file.items())
            readKey(key, value, params);
        params.validate();
    } catch (const ParameterError& error) {
        throw InputError(fmt::format("{}: {}", path.string(), error.what()));
    }
}

bool writeTransferFile(const std::filesystem::path& path, const TransferParams& params)
{
    Json file = {{"range", params.range.value()}, {"color_scale", nameOf(params.colorScale)}};
    if (params.colors.empty()) file["colormap"] = params.colorMap;
    for (const auto& [position, color] : params.colors)
        file["colors"].push_back({position, color[0], color[1], color[2]});
    for (const auto& [position, opacity] : params.opacity)
        file["opacity"].push_back({position, opacity});
    if (!params.unit.empty()) file["unit"] = params.unit;
    if (params.opacityRange) file["opacity_range"] = *params.opacityRange;
    if (params.opacityScale) file["opacity_scale"] = nameOf(*params.opacityScale);
    if (!params.opacityUnit.empty()) file["opacity_unit"] = params.opacityUnit;
    return writeReport(path, jsonText(file));
}

} // namespace vdblic
