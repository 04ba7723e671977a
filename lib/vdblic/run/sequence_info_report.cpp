#include "vdblic/core/memory.h"
#include "vdblic/io/json_file.h"
#include "vdblic/run/sequence_advice.h"
#include "vdblic/run/sequence_info.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <string>

namespace vdblic {
namespace {

std::string coordText(const openvdb::Coord& at)
{
    return fmt::format("[{} {} {}]", at[0], at[1], at[2]);
}

std::string voxelText(const GridInfo& grid)
{
    if (grid.mostVoxels == 0) return "no active voxels told";
    return grid.leastVoxels == grid.mostVoxels ? fmt::format("{} voxels", grid.mostVoxels)
                                               : fmt::format("{} to {} voxels", grid.leastVoxels, grid.mostVoxels);
}

void addGrid(const GridInfo& grid, std::size_t files, std::vector<std::string>& lines)
{
    std::string text = fmt::format("  grid {} ({}, {}): {}", grid.name, grid.type, grid.gridClass, voxelText(grid));
    if (!grid.box.empty()) text += fmt::format(" in {} to {}", coordText(grid.box.min()), coordText(grid.box.max()));
    const openvdb::Vec3d size = grid.transform->voxelSize();
    text += size[0] == size[1] && size[1] == size[2]
                ? fmt::format(", voxel size {:.6g}", size[0])
                : fmt::format(", voxel size {:.6g} {:.6g} {:.6g}", size[0], size[1], size[2]);
    if (grid.files < files) text += fmt::format("; in {} of {} files", grid.files, files);
    lines.push_back(text);
    if (!grid.values) return;
    const ValueInfo& values = *grid.values;
    if (!values.isFinite()) return lines.push_back(fmt::format("    none of {} values is finite", values.notFinite));
    lines.push_back(fmt::format("    values {:.6g} to {:.6g}{}", values.low, values.high,
                                values.notFinite == 0 ? "" : fmt::format(", {} not finite", values.notFinite)));
}

/// Three numbers, or one if all are equal.
template<typename Number>
std::string shortText(const std::array<Number, 3>& numbers)
{
    const bool isOne = numbers[0] == numbers[1] && numbers[1] == numbers[2];
    return isOne ? fmt::format("{}", numbers[0]) : fmt::format("{}", fmt::join(numbers, " "));
}

void addVelocity(const VelocityInfo& velocity, std::vector<std::string>& lines)
{
    lines.push_back(fmt::format("  velocity: grid {}; unit {} x {}; {:.6g} s between frames ({})", velocity.grid,
                                nameOf(velocity.unit), velocity.scale, velocity.interval, velocity.intervalSource));
    if (velocity.motion) {
        lines.push_back(fmt::format(
            "    moves at most {:.3g} voxels a step, in frame {}, {:.3g} on average, and {:.2g} "
            "in its faster half",
            velocity.motion->largest, velocity.motion->frame, velocity.motion->mean, velocity.motion->fasterHalf));
    }
    lines.push_back(fmt::format("    vdblic_advect takes about {} of memory and {:.2g} s of processor time",
                                memoryText(velocity.memory), velocity.seconds));
    std::vector<std::string> costs;
    for (const MethodCost& cost : velocity.lookingBack)
        costs.push_back(fmt::format("{} {} and {:.2g} s", cost.method, memoryText(cost.memory), cost.seconds));
    lines.push_back(fmt::format("    with `method` {}", fmt::join(costs, ", ")));
    if (!velocity.streaks) return;
    const StreaksInfo& streaks = *velocity.streaks;
    const std::string tail = streaks.tail ? fmt::format(" `tail` {}", *streaks.tail) : "";
    lines.push_back(fmt::format("    vdblic_advect `method` streaks `spacing` {}{} `refine` {} takes about {} and "
                                "{:.2g} s, with `draw` lines {} and {:.2g} s",
                                shortText(streaks.spacing), tail, shortText(streaks.refine), memoryText(streaks.memory),
                                streaks.seconds, memoryText(streaks.lineMemory), streaks.lineSeconds));
}

nlohmann::json ofGrid(const GridInfo& grid)
{
    const auto array = [](const auto& v) { return nlohmann::json{v[0], v[1], v[2]}; };
    nlohmann::json result = {{"name", grid.name},
                             {"type", grid.type},
                             {"class", grid.gridClass},
                             {"files", grid.files},
                             {"of_name", grid.ofName},
                             {"least_voxels", grid.leastVoxels},
                             {"most_voxels", grid.mostVoxels},
                             {"voxel_size", array(grid.transform->voxelSize())},
                             {"transform_changes", grid.transformChanges}};
    if (!grid.box.empty()) result["box"] = {array(grid.box.min()), array(grid.box.max())};
    if (grid.values) {
        if (grid.values->isFinite()) {
            result["low"] = grid.values->low;
            result["high"] = grid.values->high;
        }
        result["not_finite"] = grid.values->notFinite;
    }
    return result;
}

nlohmann::json ofVelocity(const VelocityInfo& velocity)
{
    nlohmann::json result = {{"grid", velocity.grid},
                             {"unit", nameOf(velocity.unit)},
                             {"scale", velocity.scale},
                             {"interval", velocity.interval},
                             {"interval_source", velocity.intervalSource},
                             {"memory", velocity.memory},
                             {"processor_seconds", velocity.seconds}};
    for (const MethodCost& cost : velocity.lookingBack)
        result[std::string(cost.method)] = {{"memory", cost.memory}, {"processor_seconds", cost.seconds}};
    if (velocity.streaks) {
        const StreaksInfo& streaks = *velocity.streaks;
        result["streaks"] = {
            {"spacing", streaks.spacing},
            {"refine", streaks.refine},
            {"memory", streaks.memory},
            {"processor_seconds", streaks.seconds},
            {"as_lines", {{"memory", streaks.lineMemory}, {"processor_seconds", streaks.lineSeconds}}}};
        if (streaks.tail) result["streaks"]["tail"] = *streaks.tail;
    }
    if (velocity.motion) {
        result["largest_displacement"] = velocity.motion->largest;
        result["largest_displacement_frame"] = velocity.motion->frame;
        result["mean_displacement"] = velocity.motion->mean;
        result["faster_half_displacement"] = velocity.motion->fasterHalf;
    }
    return result;
}

} // namespace

std::vector<std::string> infoLines(const SequenceInfo& info)
{
    std::vector<std::string> lines;
    const std::size_t files = info.frames.size();
    lines.push_back(fmt::format("{}: {} {}, {}; {}; {} with checksums{}", info.pattern, files,
                                files == 1 ? "frame" : "frames", frameListText(info.frames),
                                memoryText(double(info.bytes)), info.withChecksums,
                                info.creator.empty() ? "" : "; by " + info.creator));
    for (const GridInfo& grid : info.grids)
        addGrid(grid, files - info.damaged.size(), lines);
    if (info.velocity) addVelocity(*info.velocity, lines);
    for (const std::string& damage : info.damaged)
        lines.push_back("  damaged: " + damage);
    for (const std::string& advice : info.advice)
        lines.push_back("  advice: " + advice);
    return lines;
}

std::string toJson(const std::vector<SequenceInfo>& sequences)
{
    nlohmann::json all = nlohmann::json::array();
    for (const SequenceInfo& info : sequences) {
        nlohmann::json grids = nlohmann::json::array();
        for (const GridInfo& grid : info.grids)
            grids.push_back(ofGrid(grid));
        nlohmann::json sequence = {
            {"pattern", info.pattern}, {"creator", info.creator}, {"frames", info.frames},
            {"missing", info.missing}, {"bytes", info.bytes},     {"with_checksums", info.withChecksums},
            {"damaged", info.damaged}, {"grids", grids},          {"advice", info.advice}};
        if (info.velocity) sequence["velocity"] = ofVelocity(*info.velocity);
        all.push_back(sequence);
    }
    return jsonText(nlohmann::json{{"sequences", all}});
}

} // namespace vdblic
