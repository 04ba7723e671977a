#include "vdblic/flow/velocity_frame.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/paging.h"
#include "vdblic/field/centred_velocity.h"
#include "vdblic/field/index_axes.h"
#include "vdblic/field/largest_value.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/io/velocity_grids.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Mat3d;
using openvdb::Vec3f;
using openvdb::Vec3SGrid;

bool isFinite(const Vec3f& v)
{
    return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

/// Whether all active values of a leaf are finite.
VDBLIC_KERNEL bool isFinite(const Domain::Mask& mask, const Vec3f* values)
{
    Int8 isOdd{};
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const Vector8 v = activeValues(mask, values, row);
        const Float8 zero = (v.x - v.x) + (v.y - v.y) + (v.z - v.z); // NaN unless all are finite
        isOdd |= zero != 0;
    }
    return !anyOf(isOdd);
}

/// The number of active voxels that are not finite, and the first of them.
std::pair<std::size_t, Coord> findNonFinite(const Vec3SGrid& grid)
{
    std::vector<const openvdb::Vec3STree::LeafNodeType*> leaves;
    leaves.reserve(grid.tree().leafCount());
    grid.tree().getNodes(leaves);
    const bool all = tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, leaves.size()), true,
        [&](const tbb::blocked_range<std::size_t>& range, bool finite) {
            for (std::size_t i = range.begin(); finite && i < range.end(); ++i) {
                const auto& leaf = *leaves[i];
                paging::breathe(paging::kLeafBytes);
                finite = leaf.buffer().empty() || isFinite(leaf.valueMask(), leaf.buffer().data());
            }
            return finite;
        },
        std::logical_and<>());
    std::size_t count = 0;
    Coord first;
    auto value = grid.cbeginValueOn();
    if (all) value.setMaxDepth(value.getLeafDepth() - 1); // visit tiles only
    for (; value; ++value) {
        if (isFinite(*value)) continue;
        if (count == 0) first = value.getCoord();
        count += value.getVoxelCount();
    }
    return {count, first};
}

/// Refuse velocities that are not finite, or set them to 0 and add a remark.
void mendNonFinite(VelocityFrame& frame, NonFinite nonFinite)
{
    const auto [count, first] = findNonFinite(*frame.values);
    if (count == 0) return;
    const std::string found =
        fmt::format("{}: grid {}: {} {} not finite, the first at [{}, {}, {}]", frame.file.label(), frame.gridName,
                    count, count == 1 ? "voxel is" : "voxels are", first[0], first[1], first[2]);
    if (nonFinite == NonFinite::kRefuse) throw InputError(found + "; mend the values or give `non_finite` zero");
    frame.values = frame.values->deepCopy();
    for (auto value = frame.values->beginValueOn(); value; ++value) {
        if (!isFinite(*value)) value.setValue(Vec3f(0));
    }
    frame.remarks.push_back(found + "; set to zero");
}

/// A text of a grid's metadata, else of the file's, else empty.
std::string textMetadata(const openvdb::GridBase& grid, const openvdb::MetaMap& file, const char* key)
{
    for (const openvdb::MetaMap* metadata : {static_cast<const openvdb::MetaMap*>(&grid), &file}) {
        if (const auto text = metadata->getMetadata<openvdb::StringMetadata>(key)) return text->value();
    }
    return {};
}

void carry(const VdbFile& file, const std::vector<std::string>& names, VelocityFrame& frame)
{
    for (const std::string& name : names)
        frame.carried.push_back(file.get<openvdb::GridBase>(name, "`carry`"));
}

} // namespace

Parameters parametersOf(VelocityParams& params)
{
    constexpr double kMost = 1e18; // velocities are single precision
    return {
        parameter("velocity", "Name of the velocity grid, or of three scalar grids.", params.grid, {.words = "NAME"}),
        parameter("velocity_unit", "Unit of the stored velocities; world/s unless the file is known.", params.unit,
                  {.words = "UNIT"}),
        parameter("velocity_scale", "Factor on the velocities.", params.scale, {.limits = {-kMost, kMost}}),
    };
}

void VelocityParams::validate() const
{
    VelocityParams copy = *this;
    checkLimits(parametersOf(copy));
    constexpr double kLeast = 1e-18;
    if (std::abs(scale) < kLeast)
        throw ParameterError(
            fmt::format("`velocity_scale` cannot be {}: its magnitude must be {} or more", scale, kLeast));
}

VelocityConvention conventionOf(const openvdb::GridBase& grid, const VelocityParams& params)
{
    const bool isMantaflow = grid.getGridClass() == openvdb::GRID_STAGGERED && grid["file_base_resolution"];
    return {params.unit.value_or(isMantaflow ? VelocityUnit::kVoxelPerSecond : VelocityUnit::kWorldPerSecond),
            params.scale * (isMantaflow && !params.unit ? kMantaflowScale : 1), isMantaflow};
}

FrameTimes timesOf(const openvdb::GridBase& grid, const openvdb::MetaMap& file)
{
    const auto of = [&](const char* key) {
        const auto ofGrid = numericMetadata(grid, key);
        return ofGrid ? ofGrid : numericMetadata(file, key);
    };
    FrameTimes times{of("time"), of("dt")};
    const bool hasOther = !times.dt && (grid["dt"] || file["dt"]); // of another type, such as text
    if (hasOther) times.dt = std::numeric_limits<double>::quiet_NaN();
    return times;
}

FromStored<Space::kWorld, Per::kSecond> VelocityFrame::toWorldPerSecond(double interval) const
{
    const bool voxels = unit == VelocityUnit::kVoxelPerSecond || unit == VelocityUnit::kVoxelPerFrame;
    const bool perFrame = unit == VelocityUnit::kWorldPerFrame || unit == VelocityUnit::kVoxelPerFrame;
    const Mat3d axes = voxels ? indexAxes(values->transform()) : Mat3d::identity();
    return {axes * (scale * (perFrame ? 1 / interval : 1))};
}

FromStored<Space::kVelocity, Per::kFrame> VelocityFrame::toVoxelsPerFrame(double interval) const
{
    return {indexAxes(values->transform()).inverse() * toWorldPerSecond(interval).matrix * (interval * motion)};
}

double VelocityFrame::largestDisplacement(double interval) const
{
    const openvdb::Mat3s toFrame(toVoxelsPerFrame(interval).matrix);
    const NumberRow squared = largestValues(values->tree(), [&](const Vector8& value) {
        const auto component = [&](int i) {
            return value.x * toFrame(i, 0) + value.y * toFrame(i, 1) + value.z * toFrame(i, 2);
        };
        return NumberRow{squaredLength({component(0), component(1), component(2)})};
    });
    return std::sqrt(double(largestLane(squared.numbers)));
}

VelocityFrame readVelocity(const FrameFile& file, const VelocityParams& params, const std::optional<VelocityPart>& part)
{
    const auto isKept = [&](const openvdb::GridBase& grid, const openvdb::Coord& origin) {
        const bool isCentred = isVector(grid) && grid.getGridClass() != openvdb::GRID_STAGGERED;
        openvdb::CoordBBox box = part->box.voxels;
        if (!isCentred) box.expand(LeafVoxel::kDim); // the values at voxel centres need the next voxels' faces
        return box.isInside(origin);
    };
    const VdbFile contents = file.contents ? *file.contents
                             : part        ? readVdb(file.path, isKept, part->verify)
                                           : readVdb(file.path);
    VelocityFrame frame;
    frame.file = file;
    frame.motion = params.motion;
    std::string name = params.grid;
    if (name.empty()) {
        std::vector<std::string> names = velocityNames(contents);
        const bool byName = !names.empty();
        if (!byName) names = vectorNames(contents);
        if (names.empty()) {
            throw contents.missing("velocity: a vector grid, or three scalars such as vel.x vel.y vel.z or u v w",
                                   "`velocity` NAME or NAME,NAME,NAME");
        }
        name = names.front();
        if (!byName) {
            frame.remarks.push_back(
                fmt::format("the files hold no grid called velocity: taking '{}'; choose with `velocity`", name));
        } else if (names.size() > 1) {
            frame.remarks.push_back(
                fmt::format("the files hold several velocities ({}): taking '{}'; choose with `velocity`",
                            fmt::join(names, ", "), name));
        }
    }
    const VelocityGrids grids = findVelocityGrids(contents, name);
    frame.gridName = grids.name;
    frame.values = centredVelocity(grids, file.path.string(), part ? std::optional(part->box.voxels) : std::nullopt);
    mendNonFinite(frame, params.nonFinite);

    static_cast<VelocityConvention&>(frame) = conventionOf(*grids.values.front(), params);
    static_cast<FrameTimes&>(frame) = timesOf(*frame.values, contents.metadata);
    if (frame.mantaflow && !params.unit) {
        frame.remarks.push_back(fmt::format(
            "a Mantaflow cache: velocities taken as voxel/s x {} (at Blender's time scale 1)", kMantaflowScale));
    }
    frame.start = textMetadata(*grids.values.front(), contents.metadata, "start");
    frame.lengthUnit = textMetadata(*grids.values.front(), contents.metadata, "length_unit");
    if (const auto creator = contents.metadata.getMetadata<openvdb::StringMetadata>("creator")) {
        frame.sourceCreator = creator->value();
    }
    carry(contents, params.carry, frame);
    return frame;
}

} // namespace vdblic
