#include "vdblic/io/velocity.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/vdb_file.h"

#include <openvdb/tree/LeafManager.h>

#include <array>
#include <cmath>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Mat3d;
using openvdb::Vec3d;
using openvdb::Vec3f;
using openvdb::Vec3SGrid;

constexpr std::array<std::string_view, 4> kUnitNames = {"world/s", "world/frame", "voxel/s", "voxel/frame"};
constexpr std::array<const char*, 3> kVelocityNames = {"velocity", "vel", "v"};
constexpr std::array<const char*, 3> kComponentJoints = {".", "_", ""};

/// Mantaflow stores voxels per its own unit of time, of which 2.5 make a second (measured at 24, 30 and 48 fps).
constexpr double kMantaflowScale = 2.5;

/// The linear part of a grid's transform: its columns are the index axes in world space.
Mat3d jacobian(const openvdb::math::Transform& transform)
{
    Mat3d columns;
    for (int axis = 0; axis < 3; ++axis) {
        Vec3d unit(0);
        unit[axis] = 1;
        columns.setCol(axis, transform.baseMap()->applyJacobian(unit));
    }
    return columns;
}

void checkTransform(const openvdb::GridBase& grid, const std::string& where)
{
    if (!grid.transform().isLinear()) {
        throw InputError(where + " has a frustum transform; resample it onto a box-shaped grid");
    }
    const Mat3d axes = jacobian(grid.transform());
    for (int a = 0; a < 3; ++a) {
        const Vec3d p = axes.col(a), q = axes.col((a + 1) % 3);
        if (!(p.length() > 0) || !std::isfinite(p.length())) {
            throw InputError(where + fmt::format(" has a voxel of size {} along axis {}", p.length(), a));
        }
        if (std::abs(p.dot(q)) > 1e-4 * p.length() * q.length()) {
            throw InputError(where + " has a sheared transform; resample it onto a grid with right angles");
        }
    }
}

void checkFinite(const Vec3SGrid& grid, const std::string& where)
{
    const auto finite = [](const Vec3f& v) {
        return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
    };
    std::size_t count = 0;
    std::optional<Coord> first;
    for (auto value = grid.cbeginValueOn(); value; ++value) {
        if (finite(*value)) continue;
        if (!first) first = value.getCoord();
        count += value.getVoxelCount();
    }
    if (count > 0) {
        throw InputError(where +
                         fmt::format(" holds {} voxels that are not finite numbers, the first at [{}, {}, {}]; mend "
                                     "the file",
                                     count, first->x(), first->y(), first->z()));
    }
}

template<typename GridT>
typename GridT::ConstPtr asType(const openvdb::GridBase::Ptr& grid)
{
    return openvdb::gridConstPtrCast<GridT>(grid);
}

/// A vector grid of single or double precision as Vec3f; null if it is neither.
Vec3SGrid::Ptr vectorGrid(const openvdb::GridBase::Ptr& grid)
{
    if (auto single = openvdb::gridPtrCast<Vec3SGrid>(grid)) return single;
    if (const auto wide = asType<openvdb::Vec3DGrid>(grid)) return std::make_shared<Vec3SGrid>(*wide);
    return nullptr;
}

openvdb::FloatGrid::ConstPtr scalarGrid(const openvdb::GridBase::Ptr& grid)
{
    if (auto single = asType<openvdb::FloatGrid>(grid)) return single;
    if (const auto wide = asType<openvdb::DoubleGrid>(grid)) return std::make_shared<openvdb::FloatGrid>(*wide);
    return nullptr;
}

/// Three scalar grids as one vector grid on the union of their voxels.
Vec3SGrid::Ptr joined(const std::array<openvdb::FloatGrid::ConstPtr, 3>& components)
{
    auto vectors = Vec3SGrid::create(Vec3f(0));
    for (const auto& component : components)
        vectors->tree().topologyUnion(component->tree());
    vectors->tree().voxelizeActiveTiles();
    openvdb::tree::LeafManager<openvdb::Vec3STree> leaves(vectors->tree());
    leaves.foreach ([&](openvdb::Vec3STree::LeafNodeType& leaf, std::size_t) {
        std::array<openvdb::FloatGrid::ConstAccessor, 3> values = {
            components[0]->getConstAccessor(), components[1]->getConstAccessor(), components[2]->getConstAccessor()};
        for (auto value = leaf.beginValueOn(); value; ++value) {
            const Coord at = value.getCoord();
            Vec3f vector(0);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                float component = 0;
                if (values[axis].probeValue(at, component)) vector[int(axis)] = component;
            }
            value.setValue(vector);
        }
    });
    vectors->setTransform(components[0]->transform().copy());
    vectors->setGridClass(components[0]->getGridClass());
    for (auto meta = components[0]->beginMeta(); meta != components[0]->endMeta(); ++meta) {
        vectors->insertMeta(meta->first, *meta->second);
    }
    return vectors;
}

/// Staggered components live on the faces at index − ½; the centre's value is the mean of its two faces.
/// Where the face beyond has no value (the rim of a sparse simulation) the nearer one stands for both.
Vec3SGrid::Ptr collocated(const Vec3SGrid& faces)
{
    auto centres = faces.deepCopy();
    centres->setGridClass(openvdb::GRID_UNKNOWN);
    centres->tree().voxelizeActiveTiles();
    openvdb::tree::LeafManager<openvdb::Vec3STree> leaves(centres->tree());
    leaves.foreach ([&](openvdb::Vec3STree::LeafNodeType& leaf, std::size_t) {
        const auto values = faces.getConstAccessor();
        for (auto value = leaf.beginValueOn(); value; ++value) {
            Vec3f mean = *value;
            for (int axis = 0; axis < 3; ++axis) {
                Coord next = value.getCoord();
                ++next[axis];
                Vec3f face;
                if (values.probeValue(next, face)) mean[axis] = 0.5f * (mean[axis] + face[axis]);
            }
            value.setValue(mean);
        }
    });
    return centres;
}

struct Found {
    std::string name;
    Vec3SGrid::Ptr values;
};

/// The grid of one name: a vector grid, or three scalars joined.
Found findNamed(const VdbFile& file, const std::string& name)
{
    for (const auto& grid : file.grids) {
        if (grid->getName() != name) continue;
        if (auto vectors = vectorGrid(grid)) return {name, vectors};
    }
    for (const char* joint : kComponentJoints) {
        std::array<openvdb::FloatGrid::ConstPtr, 3> components;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::string wanted = name + joint + "xyz"[axis];
            for (const auto& grid : file.grids) {
                if (!components[axis] && grid->getName() == wanted) components[axis] = scalarGrid(grid);
            }
        }
        if (components[0] && components[1] && components[2]) {
            return {fmt::format("{0}{1}x, {0}{1}y, {0}{1}z", name, joint), joined(components)};
        }
    }
    return {};
}

Found findVelocity(const VdbFile& file, const FrameFile& frame, const std::string& chosen)
{
    if (!chosen.empty()) {
        Found found = findNamed(file, chosen);
        if (found.values) return found;
        throw InputError(
            fmt::format("{}: no velocity '{}'; the file holds {}", frame.path.string(), chosen, file.contents()));
    }
    for (const char* name : kVelocityNames) {
        if (Found found = findNamed(file, name); found.values) return found;
    }
    throw InputError(fmt::format("{}: no Vec3 grid 'velocity', 'vel' or 'v' and no three scalars of these names; the "
                                 "file holds {}: choose with --velocity NAME",
                                 frame.path.string(), file.contents()));
}

} // namespace

VelocityUnit parseVelocityUnit(std::string_view text)
{
    for (std::size_t i = 0; i < kUnitNames.size(); ++i) {
        if (text == kUnitNames[i]) return VelocityUnit(i);
    }
    throw ParameterError(fmt::format("velocity unit '{}' is not one of {}", text, fmt::join(kUnitNames, ", ")));
}

std::string_view toString(VelocityUnit unit)
{
    return kUnitNames[std::size_t(unit)];
}

void VelocityParams::validate() const
{
    if (!std::isfinite(scale) || scale == 0) {
        throw ParameterError(fmt::format("velocity scale {} must be a finite number other than 0", scale));
    }
}

Mat3d VelocityFrame::toWorldPerSecond(double interval) const
{
    const bool voxels = unit == VelocityUnit::kVoxelPerSecond || unit == VelocityUnit::kVoxelPerFrame;
    const bool perFrame = unit == VelocityUnit::kWorldPerFrame || unit == VelocityUnit::kVoxelPerFrame;
    const Mat3d axes = voxels ? jacobian(values->transform()) : Mat3d::identity();
    return axes * (scale * (perFrame ? 1 / interval : 1));
}

Mat3d VelocityFrame::toVoxelsPerStep(double interval) const
{
    return jacobian(values->transform()).inverse() * toWorldPerSecond(interval) * interval;
}

VelocityFrame readVelocity(const FrameFile& file, const VelocityParams& params)
{
    const VdbFile contents = readVdb(file.path);
    const Found found = findVelocity(contents, file, params.grid);
    const std::string where = fmt::format("{}: grid {}", file.path.string(), found.name);
    checkTransform(*found.values, where);
    checkFinite(*found.values, where);

    VelocityFrame frame;
    frame.file = file;
    frame.gridName = found.name;
    const bool staggered = found.values->getGridClass() == openvdb::GRID_STAGGERED;
    frame.values = staggered ? collocated(*found.values) : found.values;
    frame.scale = params.scale;
    frame.unit = params.unit.value_or(VelocityUnit::kWorldPerSecond);
    if (!params.unit && staggered && (*found.values)["file_base_resolution"]) {
        frame.unit = VelocityUnit::kVoxelPerSecond;
        frame.scale *= kMantaflowScale;
        frame.remark = fmt::format("a Mantaflow cache: velocities taken as voxel/s x {}", kMantaflowScale);
    }
    const auto metadata = [&](const char* name) {
        const auto ofGrid = numericMetadata(*found.values, name);
        return ofGrid ? ofGrid : numericMetadata(contents.metadata, name);
    };
    frame.time = metadata("time");
    frame.dt = metadata("dt");
    return frame;
}

} // namespace vdblic
