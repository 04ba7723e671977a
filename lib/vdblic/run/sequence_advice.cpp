#include "vdblic/run/sequence_advice.h"

#include "vdblic/core/extent.h"
#include "vdblic/run/texture_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdblic {
namespace {

constexpr double kLeast = 0.25; // voxels a step: gives streaks of one voxel
constexpr double kGood = 4;

/// Advice to join steps, if enough frames remain. @param moves voxels a step
std::optional<std::string> longerSteps(double moves, const std::vector<std::int64_t>& frames)
{
    constexpr std::size_t kFewest = 4; // frames that remain
    const auto every = std::size_t(std::min(std::ceil(1 / moves), 1e6));
    if (frames.size() <= (kFewest - 1) * every) return std::nullopt;
    const auto spacing = std::size_t(frames[1] - frames[0]) * every;
    return fmt::format("`frames` {}-{}x{} for {:.2g} voxels a step", frames.front(), frames.back(), spacing,
                       moves * double(every));
}

/// Streaks are a few voxels thick: a coarse grid has room for few.
void adviseOnVoxels(const VelocityInfo& velocity, const GridInfo* grid, std::vector<std::string>& advice)
{
    constexpr double kFew = 250e3, kGoodVolume = 1e6, kGoodLayer = 250e3;
    if (velocity.voxels == 0 || double(velocity.voxels) > kFew) return;
    const auto voxels = double(velocity.voxels);
    const int layer = grid && !grid->box.empty() ? layerAxis(grid->box) : -1;
    if (layer < 0) {
        const double factor = std::clamp(std::ceil(std::cbrt(kGoodVolume / voxels)), 2.0, 16.0);
        advice.push_back(
            fmt::format("{} voxels make a coarse dense texture: `refine` {} gives {:.3g} million texture voxels",
                        velocity.voxels, factor, voxels * std::pow(factor, 3) / 1e6));
        return;
    }
    const double factor = std::min(std::ceil(std::sqrt(kGoodLayer / voxels)), 16.0);
    if (factor < 2) return;
    std::array<double, 3> factors{factor, factor, factor};
    factors[std::size_t(layer)] = 1;
    advice.push_back(
        fmt::format("{} voxels make a coarse dense texture: `refine` {} {} {} gives {:.3g} million texture voxels",
                    velocity.voxels, factors[0], factors[1], factors[2], voxels * factor * factor / 1e6));
}

openvdb::Vec3d worldSize(const GridInfo& grid)
{
    const openvdb::BBoxd index(grid.box.min().asVec3d(), grid.box.max().asVec3d() + 1.0);
    return grid.transform->indexToWorld(index).extents();
}

void adviseOnShape(const GridInfo& grid, std::vector<std::string>& advice)
{
    const auto factors = stretchOf(grid);
    if (!factors) return;
    const openvdb::Vec3d size = worldSize(grid);
    advice.push_back(fmt::format("the domain is flat, {:.4g} x {:.4g} x {:.4g}: vdblic_render shows it better with "
                                 "--stretch {} {} {}",
                                 size[0], size[1], size[2], (*factors)[0], (*factors)[1], (*factors)[2]));
}

} // namespace

const GridInfo* velocityGridOf(const SequenceInfo& info)
{
    if (!info.velocity) return nullptr;
    const std::string& name = info.velocity->gridNames.front();
    const auto found =
        std::find_if(info.grids.begin(), info.grids.end(), [&](const GridInfo& grid) { return grid.name == name; });
    return found == info.grids.end() ? nullptr : &*found;
}

int layerAxis(const openvdb::CoordBBox& box)
{
    int layer = -1;
    const std::array<std::int64_t, 3> extent = extentOf(box);
    for (int axis = 0; axis < 3; ++axis) {
        if (extent[std::size_t(axis)] > 1) continue;
        if (layer >= 0) return -1;
        layer = axis;
    }
    return layer;
}

std::optional<std::array<double, 3>> stretchOf(const GridInfo& grid)
{
    constexpr double kFlat = 8, kGoodShape = 4; // longest side over the shortest
    if (grid.box.empty() || !grid.transform || !grid.transform->isLinear()) return std::nullopt;
    if (layerAxis(grid.box) >= 0) return std::nullopt; // a layer is flat at any height
    const openvdb::Vec3d size = worldSize(grid);
    const double longest = std::max({size[0], size[1], size[2]}), shortest = std::min({size[0], size[1], size[2]});
    if (!(shortest > 0 && longest > kFlat * shortest)) return std::nullopt;
    std::array<double, 3> factors{1, 1, 1};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (size[int(axis)] < longest / kFlat)
            factors[axis] = std::max(1.0, std::round(longest / kGoodShape / size[int(axis)]));
    }
    return factors;
}

bool makesStreaks(double moves)
{
    return moves >= kLeast && moves <= kLargeDisplacement;
}

std::optional<std::string> motionAdvice(double moves, const std::vector<std::int64_t>& frames,
                                        const std::vector<std::string>& others)
{
    if (makesStreaks(moves)) return std::nullopt;
    if (!(moves > 0))
        return "the flow is at rest, and a texture without motion is noise: check the grid and the frames";
    const bool isSlow = moves < kLeast;
    const std::string units = others.empty() ? "" : fmt::format(" ({})", fmt::join(others, ", "));
    const std::string scaled = fmt::format("`voxels_per_frame` {} for {} motion", kGood, isSlow ? "quick" : "slow");
    return fmt::format("the faster half of the flow moves {:.2g} voxels a step, too {} for streaks: check "
                       "`velocity_unit`{} and the frame spacing, or give {}",
                       moves, isSlow ? "little" : "far", units,
                       isSlow ? longerSteps(moves, frames).value_or(scaled) : scaled);
}

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
        advice.push_back(fmt::format("{} missing; `frames` {} selects the others",
                                     info.missing.size() == 1
                                         ? fmt::format("frame {} is", info.missing.front())
                                         : fmt::format("frames {} are", frameListText(info.missing)),
                                     frameListText(info.frames)));
    }
    if (!info.damaged.empty())
        advice.push_back(info.damaged.size() == 1
                             ? "1 file cannot be read: write it again"
                             : fmt::format("{} files cannot be read: write them again", info.damaged.size()));
    for (const GridInfo& grid : info.grids) {
        const bool isVelocity = info.velocity && std::ranges::count(info.velocity->gridNames, grid.name) > 0;
        if (grid.transformChanges && isVelocity) { // textures for an observer move with the observer
            advice.push_back(
                fmt::format("the transform of grid '{}' changes between frames: resample the sequence onto "
                            "one grid, or switch an adaptive domain off",
                            grid.name));
        }
        if (grid.ofName > 1) {
            advice.push_back(fmt::format("a file holds {} grids '{}', and tools read the first: rename the others",
                                         grid.ofName, grid.name));
        }
        if (grid.values && grid.values->notFinite > 0) {
            advice.push_back(fmt::format("{} values of grid '{}' are not finite: mend them, or give `non_finite` zero",
                                         grid.values->notFinite, grid.name));
        }
    }
    if (!info.velocity) return advice;
    const GridInfo* grid = velocityGridOf(info);
    const bool isKnown = !grid || !grid->values || grid->values->isFinite();
    if (const auto& motion = info.velocity->motion; motion && isKnown) {
        const auto text = motionAdvice(motion->fasterHalf, info.frames, motion->otherUnits);
        if (text) advice.push_back(*text);
    }
    if (info.isFrozen) {
        constexpr int kFrames = 24;
        advice.push_back(
            fmt::format("one frame gives one texture: `steady_frames` {} gives a film of a flow that stays as "
                        "it is",
                        kFrames));
    }
    adviseOnVoxels(*info.velocity, grid, advice);
    if (grid) adviseOnShape(*grid, advice);
    return advice;
}

} // namespace vdblic
