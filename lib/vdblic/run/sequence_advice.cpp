#include "vdblic/run/sequence_advice.h"

#include "vdblic/run/texture_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace vdblic {
namespace {

const GridInfo* gridOf(const SequenceInfo& info, const std::string& name)
{
    // The name of three scalars lists them.
    const auto found = std::find_if(info.grids.begin(), info.grids.end(),
                                    [&](const GridInfo& grid) { return grid.name == name.substr(0, name.find(',')); });
    return found == info.grids.end() ? nullptr : &*found;
}

void adviseOnMotion(const MotionInfo& motion, std::vector<std::string>& advice)
{
    constexpr double kHardly = 0.05; // voxels a step
    const std::string others =
        motion.otherUnits.empty() ? "" : fmt::format(" ({})", fmt::join(motion.otherUnits, ", "));
    if (motion.largest > kLargeDisplacement) {
        advice.push_back(fmt::format("the flow moves up to {:.3g} voxels a step: check `velocity_unit`{}, or give "
                                     "`substeps` {} for steps of at most {} voxels",
                                     motion.largest, others, std::ceil(motion.largest / kLargeDisplacement),
                                     kLargeDisplacement));
    } else if (motion.largest < kHardly) {
        advice.push_back(fmt::format("the flow moves at most {:.3g} voxels a step, and textures need motion: check "
                                     "`velocity_unit`{} and the frame spacing",
                                     motion.largest, others));
    }
}

/// Streaks are a few voxels thick: a coarse grid shows few of them.
void adviseOnVoxels(const VelocityInfo& velocity, std::vector<std::string>& advice)
{
    constexpr double kFew = 250e3, kGood = 1e6;
    constexpr double kMost = 4;
    if (velocity.voxels == 0 || double(velocity.voxels) > kFew) return;
    const double factor = std::clamp(std::round(std::cbrt(kGood / double(velocity.voxels))), 2.0, kMost);
    advice.push_back(fmt::format("{} voxels are few for streaks: `refine` {} gives {:.3g} million texture voxels",
                                 velocity.voxels, factor, double(velocity.voxels) * std::pow(factor, 3) / 1e6));
}

void adviseOnShape(const GridInfo& grid, std::vector<std::string>& advice)
{
    constexpr double kFlat = 8, kGood = 4; // longest side over the shortest
    if (grid.box.empty() || !grid.transform || !grid.transform->isLinear()) return;
    const openvdb::BBoxd box =
        grid.transform->indexToWorld(openvdb::BBoxd(grid.box.min().asVec3d(), grid.box.max().asVec3d() + 1.0));
    const openvdb::Vec3d size = box.extents();
    const double longest = std::max({size[0], size[1], size[2]}), shortest = std::min({size[0], size[1], size[2]});
    if (!(shortest > 0 && longest > kFlat * shortest)) return;
    std::array<double, 3> factors{1, 1, 1};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (size[int(axis)] < longest / kFlat)
            factors[axis] = std::max(1.0, std::round(longest / kGood / size[int(axis)]));
    }
    advice.push_back(fmt::format("the domain is flat, {:.4g} x {:.4g} x {:.4g}: vdblic_render shows it better with "
                                 "--stretch {} {} {}",
                                 size[0], size[1], size[2], factors[0], factors[1], factors[2]));
}

} // namespace

std::string frameListText(const std::vector<std::int64_t>& frames)
{
    std::string text;
    for (std::size_t begin = 0, end = 0; begin < frames.size(); begin = end) {
        for (end = begin + 1; end < frames.size() && frames[end] == frames[end - 1] + 1;)
            ++end;
        text += fmt::format("{}{}", text.empty() ? "" : ",", frames[begin]);
        if (end - begin > 1) text += fmt::format("-{}", frames[end - 1]);
    }
    return text;
}

std::vector<std::string> adviceFor(const SequenceInfo& info)
{
    std::vector<std::string> advice;
    if (!info.missing.empty()) {
        advice.push_back(fmt::format("frames {} are missing; `frames` {} selects the others",
                                     frameListText(info.missing), frameListText(info.frames)));
    }
    if (!info.damaged.empty())
        advice.push_back(fmt::format("{} of the files cannot be read: write them again", info.damaged.size()));
    for (const GridInfo& grid : info.grids) {
        if (grid.transformChanges) {
            advice.push_back(
                fmt::format("the transform of grid '{}' changes between frames: resample the sequence onto "
                            "one grid, or switch an adaptive domain off",
                            grid.name));
        }
        if (grid.values && grid.values->notFinite > 0) {
            advice.push_back(fmt::format("{} values of grid '{}' are not finite: mend them, or give `non_finite` zero",
                                         grid.values->notFinite, grid.name));
        }
    }
    if (!info.velocity) return advice;
    if (info.velocity->motion) adviseOnMotion(*info.velocity->motion, advice);
    adviseOnVoxels(*info.velocity, advice);
    if (const GridInfo* grid = gridOf(info, info.velocity->grid)) adviseOnShape(*grid, advice);
    return advice;
}

} // namespace vdblic
