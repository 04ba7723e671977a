#include "vdblic/io/velocity_grids.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <utility>

namespace vdblic {
namespace {

constexpr std::array<const char*, 3> kVelocityNames = {"velocity", "vel", "v"};
constexpr std::array<const char*, 3> kJoints = {".", "_", ""};

bool isVector(const openvdb::GridBase& grid)
{
    return grid.isType<openvdb::Vec3SGrid>() || grid.isType<openvdb::Vec3DGrid>();
}

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

/// The three scalar grids of a name; no values if one is missing.
VelocityGrids scalarsOf(const VdbFile& file, const std::string& name)
{
    for (const char* joint : kJoints) {
        VelocityGrids found{fmt::format("{0}{1}x, {0}{1}y, {0}{1}z", name, joint), {}};
        for (const char axis : {'x', 'y', 'z'}) {
            if (auto grid = gridOf(file, name + joint + axis, isScalar)) found.values.push_back(std::move(grid));
        }
        if (found.values.size() == 3) return found;
    }
    return {};
}

} // namespace

std::vector<std::string> velocityNames(const VdbFile& file)
{
    std::vector<std::string> names;
    for (const char* name : kVelocityNames) {
        if (gridOf(file, name, isVector)) names.emplace_back(name);
    }
    for (const char* name : kVelocityNames) {
        if (!gridOf(file, name, isVector) && !scalarsOf(file, name).values.empty()) names.emplace_back(name);
    }
    if (!names.empty()) return names;
    for (const auto& grid : file.grids) {
        if (isVector(*grid)) names.push_back(grid->getName());
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
