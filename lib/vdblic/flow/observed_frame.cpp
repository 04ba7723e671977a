#include "vdblic/flow/observed_frame.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/paging.h"
#include "vdblic/field/index_axes.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/io/velocity_grids.h"

#include <fmt/format.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

namespace vdblic {
namespace {

using openvdb::Mat3d;
using openvdb::Vec3d;
using openvdb::Vec3f;

/// A map of velocities in stored units at voxels, from one in world units.
VelocityMap storedMap(const VelocityMap& world, const VelocityFrame& frame)
{
    const openvdb::math::Transform& voxels = frame.values->transform();
    const Mat3d toWorld = frame.toWorldPerSecond(1).matrix, toStored = toWorld.inverse();
    // Exact where nothing turns.
    const bool turns = world.ofVelocity != Mat3d::identity();
    return {turns ? toStored * world.ofVelocity * toWorld : world.ofVelocity,
            toStored * world.ofPlace * indexAxes(voxels),
            toStored * (world.ofPlace * voxels.indexToWorld(Vec3d(0)) + world.constant)};
}

} // namespace

void observe(VelocityFrame& frame, std::shared_ptr<const ReferenceFrame> observer, double seconds,
             const std::optional<VelocityPart>& part)
{
    frame.values = movedVelocity(*frame.values, observer->toWorldVoxels(seconds),
                                 part ? std::optional(part->box.voxels) : std::nullopt);
    const VelocityMap map = storedMap(observer->seen(seconds), frame);
    openvdb::tree::LeafManager<openvdb::Vec3STree> leaves(frame.values->tree());
    leaves.foreach ([&](openvdb::Vec3STree::LeafNodeType& leaf, std::size_t) {
        if (leaf.buffer().empty()) return;
        paging::breathe(paging::kLeafBytes);
        for (auto voxel = leaf.beginValueOn(); voxel; ++voxel)
            voxel.setValue(Vec3f(map.at(Vec3d(*voxel), voxel.getCoord().asVec3d())));
    });
    for (openvdb::GridBase::Ptr& grid : frame.carried) {
        if (observer->params().stay && observer->params().rotation != 0 && isVector(*grid)) {
            throw InputError(fmt::format("{}: grid {}: its vectors would not turn with an observer: leave it out of "
                                         "`carry`, or leave out `stay`",
                                         frame.file.path.string(), grid->getName()));
        }
        grid = grid->copyGrid();
        grid->setTransform(observer->fromWorld(grid->transform(), seconds));
    }
    frame.observer = std::move(observer);
    frame.observedSeconds = seconds;
}

VelocityPart partSeen(const VelocityPart& part, const ReferenceFrame& observer, double seconds)
{
    openvdb::CoordBBox box = observer.toWorldVoxels(seconds).around(part.box.voxels);
    box.min() &= ~(LeafVoxel::kDim - 1);
    return {{box}, part.verify};
}

void makePerSecond(VelocityFrame& frame, double interval)
{
    if (frame.unit == VelocityUnit::kWorldPerFrame) {
        frame.unit = VelocityUnit::kWorldPerSecond;
    } else if (frame.unit == VelocityUnit::kVoxelPerFrame) {
        frame.unit = VelocityUnit::kVoxelPerSecond;
    } else {
        return;
    }
    frame.scale /= interval;
}

std::array<double, 3> meanVelocity(const VelocityFrame& frame)
{
    Vec3d sum(0);
    double count = 0;
    for (auto value = frame.values->cbeginValueOn(); value; ++value) {
        sum += Vec3d(*value) * double(value.getVoxelCount());
        count += double(value.getVoxelCount());
    }
    if (count > 0) sum = frame.toWorldPerSecond(1).matrix * (sum / count);
    constexpr int kDigits = 6;
    const double largest = std::max({std::abs(sum[0]), std::abs(sum[1]), std::abs(sum[2])});
    const int decimals = largest > 0 ? std::max(kDigits - 1 - int(std::floor(std::log10(largest))), 0) : 0;
    std::array<double, 3> mean{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        mean[axis] = std::stod(fmt::format("{:.{}f}", sum[int(axis)], decimals)) + 0.0; // no negative zero
    return mean;
}

} // namespace vdblic
