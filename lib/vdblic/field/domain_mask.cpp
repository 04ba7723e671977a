#include "vdblic/field/domain_mask.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/vdb_file.h"

#include <fmt/format.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <type_traits>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3d;

/// Keep the voxels for which keep(index) is true. makeKeep() is called once per leaf.
template<typename MakeKeep>
void filterVoxels(openvdb::MaskTree& topology, const MakeKeep& makeKeep)
{
    openvdb::tree::LeafManager<openvdb::MaskTree> leaves(topology);
    leaves.foreach ([&](Domain::Leaf& leaf, std::size_t) {
        const auto keep = makeKeep();
        const Domain::Mask voxels = leaf.getValueMask();
        for (auto voxel = voxels.beginOn(); voxel; ++voxel) {
            if (!keep(leaf.offsetToGlobalCoord(voxel.pos()))) leaf.setValueOff(voxel.pos());
        }
    });
}

/// The smallest index box that holds every voxel whose centre may lie in a world-space box.
openvdb::CoordBBox indexBox(const std::array<double, 6>& world, const openvdb::math::Transform& transform)
{
    const openvdb::BBoxd box = openvdb::BBoxd(Vec3d(world[0], world[1], world[2]), Vec3d(world[3], world[4], world[5]))
                                   .applyInverseMap(*transform.baseMap());
    const auto clamped = [far = Vec3d(1 << 30)](const Vec3d& corner) {
        return openvdb::math::minComponent(openvdb::math::maxComponent(corner, -far), far);
    };
    return {Coord::floor(clamped(box.min())), Coord::ceil(clamped(box.max()))};
}

void cutByWorldBox(openvdb::MaskTree& topology, const std::array<double, 6>& world,
                   const openvdb::math::Transform& transform, int ranks)
{
    checkVoxels(topology.activeVoxelCount(), "", ranks, topology.activeLeafVoxelCount());
    topology.voxelizeActiveTiles();
    filterVoxels(topology, [&] {
        return [&](const Coord& voxel) {
            const Vec3d at = transform.indexToWorld(voxel);
            for (int axis = 0; axis < 3; ++axis) {
                if (at[axis] < world[std::size_t(axis)] || at[axis] > world[std::size_t(axis) + 3]) return false;
            }
            return true;
        };
    });
}

/// Whether a mask's value includes a voxel.
template<typename GridT>
bool includes(const typename GridT::ConstAccessor& mask, const Coord& at, bool levelSet)
{
    if constexpr (std::is_same_v<GridT, openvdb::MaskGrid>) {
        return mask.isValueOn(at);
    } else if constexpr (std::is_same_v<GridT, openvdb::BoolGrid>) {
        return mask.getValue(at);
    } else {
        return levelSet ? mask.getValue(at) < 0 : mask.getValue(at) > 0;
    }
}

using MaskTypes = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                                    openvdb::BoolGrid, openvdb::MaskGrid>;

void cutByMask(openvdb::MaskTree& topology, const openvdb::math::Transform& transform, const openvdb::GridBase& mask,
               const std::string& where, int ranks)
{
    checkVoxels(topology.activeVoxelCount(), "", ranks, topology.activeLeafVoxelCount());
    topology.voxelizeActiveTiles();
    const bool levelSet = mask.getGridClass() == openvdb::GRID_LEVEL_SET;
    const bool known = mask.apply<MaskTypes>([&](const auto& typed) {
        using GridT = std::decay_t<decltype(typed)>;
        filterVoxels(topology, [&] {
            return [&, values = typed.getConstAccessor()](const Coord& voxel) {
                const Vec3d inMask = typed.worldToIndex(transform.indexToWorld(voxel));
                return includes<GridT>(values, Coord::round(inMask), levelSet);
            };
        });
    });
    if (!known) {
        throw InputError(
            fmt::format("{}: a {} grid cannot mask; use a numeric, bool or mask grid", where, mask.valueType()));
    }
}

openvdb::GridBase::Ptr readMask(const std::string& argument, std::int64_t frame, std::string& where)
{
    const auto [pattern, name] = parseGridReference(argument);
    const std::filesystem::path path = FramePattern(pattern.string()).path(frame);
    const VdbFile file = readVdb(path);
    const bool first = name.empty() && !file.grids.empty();
    auto grid = first ? file.grids.front() : file.get<openvdb::GridBase>(name, "FILE:GRID");
    where = fmt::format("mask {}: grid {}", path.string(), grid->getName());
    return grid;
}

/// @param topology the active voxels of a velocity. @throws InputError
Period periodOf(const openvdb::MaskTree& topology, const std::vector<std::string>& axes)
{
    Period period;
    openvdb::CoordBBox box;
    if (axes.empty() || !topology.evalActiveVoxelBoundingBox(box)) return period;
    for (const std::string& name : axes) {
        const int axis = name[0] - 'x', first = box.min()[axis], size = box.dim()[axis];
        if (LeafVoxel::local(first) != 0 || LeafVoxel::local(size) != 0) {
            throw InputError(
                fmt::format("along {} its {} voxels, {} to {}, cannot be `periodic`: a period is a multiple "
                            "of {} voxels and begins at one; leave a repeated last layer out with `box`, "
                            "or give the velocity another size, as vdblic_import --size does",
                            name, size, first, box.max()[axis], LeafVoxel::kDim));
        }
        period.first[axis] = first;
        period.size[axis] = size;
    }
    return period;
}

} // namespace

Parameter periodicParameter(std::vector<std::string>& axes)
{
    Parameter result =
        parameter("periodic", "Axes along which the flow repeats: what leaves on one side enters on the other.", axes,
                  {.words = "AXIS,AXIS"});
    result.choices = {"x", "y", "z"};
    return result;
}

Parameters parametersOf(DomainParams& params)
{
    return {
        parameter("mask", "Compute only where a grid is above 0 (a level set: below): one file or a sequence.",
                  params.mask, {.words = "FILE[:GRID]"}),
        parameter("box", "Compute only in a box of voxels: first and last.", params.box,
                  {.option = "--bbox", .words = "X Y Z X Y Z"}),
        parameter("world_box", "Compute only in a box of world space: low and high corner.", params.worldBox,
                  {.option = "--bbox-world", .words = "X Y Z X Y Z"}),
        periodicParameter(params.periodic),
        refineParameter("Texture voxels along each axis in a voxel of the velocity.", params.refinement),
        parameter("interpolation", "Of the velocity between its voxels, with refinement.",
                  params.refinement.interpolation, {.words = "HOW"}),
    };
}

void DomainParams::validate() const
{
    const auto check = [](const auto& corners, const char* what) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (!(corners[axis] <= corners[axis + 3])) {
                throw ParameterError(fmt::format("{}: the lower corner {} is above the upper one {} along axis {}",
                                                 what, corners[axis], corners[axis + 3], axis));
            }
        }
    };
    if (box) check(*box, "box");
    if (worldBox) check(*worldBox, "world box");
    refinement.validate();
    for (const std::string& axis : periodic) {
        if (std::count(periodic.begin(), periodic.end(), axis) > 1)
            throw ParameterError(fmt::format("`periodic` has the axis {} twice", axis));
    }
}

FrameDomain makeDomain(openvdb::MaskTree::Ptr topology, const openvdb::math::Transform& transform,
                       const DomainParams& params, std::int64_t frame, int ranks)
{
    const Refinement& refinement = params.refinement;
    if (params.box) {
        const auto& b = *params.box;
        topology->clip({Coord(b[0], b[1], b[2]), Coord(b[3], b[4], b[5])});
    }
    const Period period = periodOf(*topology, params.periodic);
    const openvdb::MaskTree::Ptr texture = refinement.isNone() ? topology : refinement.refined(*topology, ranks);
    const openvdb::math::Transform::Ptr textureTransform = refinement.refined(transform);
    if (params.worldBox) {
        texture->clip(indexBox(*params.worldBox, *textureTransform));
        cutByWorldBox(*texture, *params.worldBox, *textureTransform, ranks);
    }
    if (!params.mask.empty()) {
        std::string where;
        const auto mask = readMask(params.mask, frame, where);
        cutByMask(*texture, *textureTransform, *mask, where, ranks);
    }
    const auto ofTexture = std::make_shared<Domain>(texture, ranks, refinement.refined(period));
    if (refinement.isNone()) return {ofTexture};
    if (params.worldBox || !params.mask.empty()) topology = refinement.coarsened(*texture, *topology);
    return {ofTexture, std::make_shared<Domain>(topology, ranks, period), refinement};
}

} // namespace vdblic
