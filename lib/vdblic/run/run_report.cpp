#include "vdblic/run/run_report.h"

#include "vdblic/io/json_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace vdblic {
namespace {

using Json = nlohmann::ordered_json;

struct Stage {
    const char* name;
    double (*seconds)(const FrameReport&);
};
constexpr Stage kStages[] = {
    {"read", [](const FrameReport& frame) { return frame.read; }},
    {"load", [](const FrameReport& frame) { return frame.times.load; }},
    {"scatter", [](const FrameReport& frame) { return frame.times.scatter; }},
    {"convolve", [](const FrameReport& frame) { return frame.times.convolve; }},
    {"filter", [](const FrameReport& frame) { return frame.times.filter; }},
    {"write", [](const FrameReport& frame) { return frame.write; }},
};

double computing(const FrameReport& frame)
{
    return frame.times.load + frame.times.scatter + frame.times.convolve + frame.times.filter;
}

/// Mean and standard deviation over the frames.
struct Spread {
    double mean = 0, deviation = 0;
};
Spread spreadOf(const RunReport& report, const std::function<double(const FrameReport&)>& figure)
{
    Spread spread;
    const auto count = double(std::max<std::size_t>(report.frames.size(), 1));
    for (const FrameReport& frame : report.frames)
        spread.mean += figure(frame) / count;
    for (const FrameReport& frame : report.frames)
        spread.deviation += std::pow(figure(frame) - spread.mean, 2) / count;
    spread.deviation = std::sqrt(spread.deviation);
    return spread;
}

double stepsPerVoxel(const FrameReport& frame)
{
    return double(frame.stats.steps) / double(std::max<std::size_t>(frame.voxels, 1));
}

Json ofFrame(const FrameReport& frame)
{
    const ScatterStats& stats = frame.stats;
    Json seconds;
    for (const Stage& stage : kStages)
        seconds[stage.name] = stage.seconds(frame);
    return {{"frame", frame.frame},
            {"voxels", frame.voxels},
            {"went_on", stats.particles},
            {"blocked", stats.blocked},
            {"released", stats.released},
            {"reused", stats.reused},
            {"copied", stats.copied},
            {"steps", stats.steps},
            {"deposits", stats.deposits},
            {"hits", stats.hits},
            {"empty_voxels", stats.emptyVoxels},
            {"seconds", std::move(seconds)}};
}

} // namespace

std::string frameLine(const FrameReport& frame)
{
    const ScatterStats& stats = frame.stats;
    const StageTimes& times = frame.times;
    return fmt::format(
        "frame {}: {} voxels; particles: {} went on, {} blocked, {} released; seeds: {} reused, {} copied; "
        "{} steps, {} deposits, {} voxels without; seconds: load {:.3f}, scatter {:.3f}, convolve {:.3f}, "
        "filter {:.3f}",
        frame.frame, frame.voxels, stats.particles, stats.blocked, stats.released, stats.reused, stats.copied,
        stats.steps, stats.deposits, stats.emptyVoxels, times.load, times.scatter, times.convolve, times.filter);
}

std::vector<std::string> runLines(const RunReport& report)
{
    if (report.frames.empty()) return {};
    std::string stages;
    for (const Stage& stage : kStages) {
        const Spread spread = spreadOf(report, stage.seconds);
        stages += fmt::format("{}{} {:.3f}", stages.empty() ? "" : ", ", stage.name, spread.mean);
    }
    const Spread time = spreadOf(report, computing), steps = spreadOf(report, stepsPerVoxel);
    return {fmt::format("{} frames in {:.1f} s; seconds a frame: {} (read and write beside the others)",
                        report.frames.size(), report.seconds, stages),
            fmt::format("balance: {:.3f} s of computing a frame, deviation {:.1f} %; {:.2f} steps a voxel, deviation "
                        "{:.1f} %",
                        time.mean, time.mean > 0 ? 100 * time.deviation / time.mean : 0, steps.mean,
                        steps.mean > 0 ? 100 * steps.deviation / steps.mean : 0)};
}

std::string toJson(const RunReport& report)
{
    Json stages, frames = Json::array();
    for (const Stage& stage : kStages)
        stages[stage.name] = spreadOf(report, stage.seconds).mean;
    for (const FrameReport& frame : report.frames)
        frames.push_back(ofFrame(frame));
    const auto figures = [](const Spread& spread) {
        return Json{{"mean", spread.mean}, {"deviation", spread.deviation}};
    };
    const Json result = {{"seconds", report.seconds},
                         {"mean_seconds_by_stage", stages},
                         {"computing_seconds", figures(spreadOf(report, computing))},
                         {"steps_per_voxel", figures(spreadOf(report, stepsPerVoxel))},
                         {"frames", frames}};
    return jsonText(result);
}

} // namespace vdblic
