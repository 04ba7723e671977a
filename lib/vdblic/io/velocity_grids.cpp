#include "vdblic/io/velocity_grids.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <string_view>
#include <utility>

namespace vdblic {
namespace {

constexpr std::array<const char*, 3> kVelocityNames = {"velocity", "vel", "v"};
constexpr std::array<const char*, 3> kJoints = {".", "_", ""};
constexpr std::array<const char*, 2> kAxes = {"xyz", "XYZ"};
constexpr std::array<const char*, 2> kComponents = {"u,v,w", "U,V,W"};
/// Vector grids that are known to be something else, in lower case.
constexpr std::array<std::string_view, 14> kOtherMeanings = {"vorticity", "curl",         "color", "colour", "cd",
                                                             "rgb",       "gradient",     "grad",  "normal", "n",
                                                             "force",     "displacement", "rest",  "uv"};

bool isScalar(const openvdb::GridBase& grid)
{
    return grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>();
}

openvdb::GridBase::Ptr gridOf(const VdbFile& file, const std::string& name, bool (*isType)(const openvdb::GridBase&))
{
    for (const auto& grid : file.grids) {
        if (grid->getName() == name && isType(*grid)) return grid;
    }
    return nullptr;
}

/// The scalar grids of three names; no values if one is missing.
VelocityGrids threeScalars(const VdbFile& file, const std::array<std::string, 3>& names)
{
    VelocityGrids found{fmt::format("{}", fmt::join(names, ", ")), {}};
    for (const std::string& name : names) {
        auto grid = gridOf(file, name, isScalar);
        if (!grid) return {};
        found.values.push_back(std::move(grid));
    }
    return found;
}

/// The three scalar grids of a name, or of three names with commas between; no values if one is missing.
VelocityGrids scalarsOf(const VdbFile& file, const std::string& name)
{
    const std::size_t first = name.find(','), second = name.find(',', first + 1);
    if (second != std::string::npos)
        return threeScalars(
            file, {name.substr(0, first), name.substr(first + 1, second - first - 1), name.substr(second + 1)});
    for (const char* joint : kJoints) {
        for (const char* axes : kAxes) {
            VelocityGrids found =
                threeScalars(file, {name + joint + axes[0], name + joint + axes[1], name + joint + axes[2]});
            if (!found.values.empty()) return found;
        }
    }
    return {};
}

bool meansOther(std::string name)
{
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return std::find(kOtherMeanings.begin(), kOtherMeanings.end(), name) != kOtherMeanings.end();
}

} // namespace

bool isVector(const openvdb::GridBase& grid)
{
    return grid.isType<openvdb::Vec3SGrid>() || grid.isType<openvdb::Vec3DGrid>();
}

std::vector<std::string> velocityNames(const VdbFile& file)
{
    std::vector<std::string> names;
    for (const char* name : kVelocityNames) {
        if (gridOf(file, name, isVector)) names.emplace_back(name);
    }
    for (const char* name : kVelocityNames) {
        if (!gridOf(file, name, isVector) && !scalarsOf(file, name).values.empty()) names.emplace_back(name);
    }
    for (const char* name : kComponents) {
        if (!scalarsOf(file, name).values.empty()) names.emplace_back(name);
    }
    return names;
}

std::vector<std::string> vectorNames(const VdbFile& file)
{
    std::vector<std::string> names;
    for (const auto& grid : file.grids) {
        if (isVector(*grid) && !meansOther(grid->getName())) names.push_back(grid->getName());
    }
    return names;
}

VelocityGrids findVelocityGrids(const VdbFile& file, const std::string& name)
{
    if (auto grid = gridOf(file, name, isVector)) return {name, {std::move(grid)}};
    VelocityGrids scalars = scalarsOf(file, name);
    if (scalars.values.empty()) throw file.missing(fmt::format("velocity '{}'", name), "`velocity`");
    return scalars;
}

} // namespace vdblic
