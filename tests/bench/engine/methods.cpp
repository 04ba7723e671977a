#include "bench/engine/methods.h"

#include "bench/engine/clock.h"
#include "bench/engine/coherence_meter.h"
#include "bench/engine/euler_uflic.h"
#include "bench/engine/scap_auflic.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/methods/registry.h"
#include "vdblic/noise/noise_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace vdblic::bench {
namespace {

/// Run a method that works scattering process by scattering process, and so needs the velocities of a life span ahead.
template<typename Method>
Figures runProcesses(const Flow& flow, int lifeSpan, Method&& method)
{
    Figures figures;
    CoherenceMeter meter;
    double cpu = 0;
    std::vector<VelocityField> fields(flow.steps() + std::size_t(lifeSpan));
    for (std::size_t k = 0; k < fields.size(); ++k)
        flow.build(std::min(k, flow.steps() - 1), fields[k]);
    for (std::size_t k = 0; k < flow.steps(); ++k) {
        const double before = cpuTime();
        const LeafValues<float> texture = method.scatteringProcess(k, fields);
        if (k < std::size_t(lifeSpan)) continue; // the buckets fill
        cpu += cpuTime() - before;
        figures.voxels += double(flow.frames[k].domain.texture->voxelCount());
        figures.stats += method.stats();
        meter.add(flow, k, texture, figures);
    }
    figures.nanoseconds = 1e9 * cpu / figures.voxels;
    return figures;
}

TextureParams scatterParams(const TextureMethod* method, int lifeSpan, float window)
{
    TextureParams params;
    params.method = method;
    params.lifeSpan = lifeSpan;
    params.releaseWindow = window;
    return params;
}

} // namespace

Figures runPipeline(const Flow& flow, const TextureParams& scatter, bool coherence)
{
    const auto pipeline = makeFlowTexture({scatter}, {NoiseField(1)});
    Figures figures;
    CoherenceMeter meter;
    for (int i = 0; i < scatter.lifeSpan; ++i)
        (void)pipeline->advance({flow.frames[0], flow.frames[0], flow.interval});
    double cpu = 0, wall = 0;
    for (std::size_t k = 0; k < flow.steps(); ++k) {
        const double cpuBefore = cpuTime(), wallBefore = wallTime();
        const TextureFrame result = pipeline->advance(flow.step(k));
        cpu += cpuTime() - cpuBefore;
        wall += wallTime() - wallBefore;
        figures.times += result.times;
        figures.stats += result.stats;
        figures.voxels += double(flow.frames[k].domain.texture->voxelCount());
        if (coherence) meter.add(flow, k, result.texture, figures);
    }
    figures.nanoseconds = 1e9 * cpu / figures.voxels;
    figures.wallNanoseconds = 1e9 * wall / figures.voxels;
    return figures;
}

nlohmann::json compareMethods(const Flow& flow, const char* title)
{
    printHeading(title);
    nlohmann::json rows;
    rows.push_back(printRow("UFLIC as in the paper, Euler", runProcesses(flow, 4, EulerUflic(4, NoiseField(1)))));
    rows.push_back(printRow("UFLIC", runPipeline(flow, scatterParams(&kUflic, 4, 1), true)));
    rows.push_back(
        printRow("AUFLIC as in the paper, window 0.25", runProcesses(flow, 4, ScapAuflic(4, 0.25f, NoiseField(1)))));
    for (const float window : {0.125f, 0.25f, 0.5f}) {
        rows.push_back(printRow(fmt::format("AUFLIC as published, window {}", window),
                                runPipeline(flow, scatterParams(&kAuflic2004, 4, window), true)));
        rows.push_back(printRow(fmt::format("AUFLIC, window {}", window),
                                runPipeline(flow, scatterParams(&kAuflic, 4, window), true)));
    }
    return rows;
}

} // namespace vdblic::bench
