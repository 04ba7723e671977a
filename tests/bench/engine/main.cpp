/// The engine's benchmark: what methods cost, how time grows with life span, size and threads, and the integrator
/// beside OpenVDB's own, as JSON for tests/bench/tables.py. The first figures are of one thread.

#include "bench/engine/clock.h"
#include "bench/engine/euler_uflic.h"
#include "bench/engine/flow.h"
#include "bench/engine/integrators.h"
#include "vdblic/methods/registry.h"
#include "vdblic/noise/noise_field.h"

#include <nlohmann/json.hpp>
#include <openvdb/openvdb.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <vector>

namespace vdblic::bench {
namespace {

constexpr int kLifeSpan = 4;

/// Nanoseconds a voxel and frame.
struct Cost {
    double processor = 0, wall = 0;
};

TextureParams params(const TextureMethod& method, int lifeSpan = kLifeSpan)
{
    TextureParams result;
    result.method = &method;
    result.lifeSpan = lifeSpan;
    return result;
}

/// The cost of a method, after a preroll of one life span that is not measured.
Cost costOf(const Flow& flow, const TextureParams& params)
{
    const auto texture = makeFlowTexture({params}, {NoiseField(1)});
    for (int i = 0; i < params.lifeSpan; ++i)
        (void)texture->advance({flow.frames[0], flow.frames[0], flow.interval});
    const double cpu = cpuTime(), wall = wallTime();
    for (std::size_t k = 0; k < flow.steps(); ++k)
        (void)texture->advance(flow.step(k));
    const double voxels = double(flow.frames[0].domain.texture->voxelCount() * flow.steps());
    return {1e9 * (cpuTime() - cpu) / voxels, 1e9 * (wallTime() - wall) / voxels};
}

/// That of the paper's UFLIC, which needs the velocities of a life span ahead, once its buckets are filled.
double costOfEulerUflic(const Flow& flow)
{
    std::vector<VelocityField> fields(flow.steps() + kLifeSpan);
    for (std::size_t k = 0; k < fields.size(); ++k)
        flow.build(std::min(k, flow.steps() - 1), fields[k]);
    EulerUflic method(kLifeSpan, NoiseField(1));
    double cpu = 0;
    for (std::size_t k = 0; k < flow.steps(); ++k) {
        const double before = cpuTime();
        (void)method.scatteringProcess(k, fields);
        if (k >= kLifeSpan) cpu += cpuTime() - before;
    }
    return 1e9 * cpu / double(flow.frames[0].domain.texture->voxelCount() * (flow.steps() - kLifeSpan));
}

nlohmann::json measure()
{
    using tbb::global_control;
    nlohmann::json report;
    const Flow paper = analyticFlow({144, 73, 81}, 7);
    {
        const global_control one(global_control::max_allowed_parallelism, 1);
        report["steps"] = {{"ours", ourStepRate(paper)}, {"OpenVDB", openvdbStepRate(paper)}};
        report["methods"] = {{"AUFLIC", costOf(paper, params(kAuflic)).processor},
                             {"UFLIC", costOf(paper, params(kUflic)).processor},
                             {"Euler UFLIC", costOfEulerUflic(paper)}};
    }
    const Flow cube = analyticFlow({96, 96, 96}, 7);
    for (const int life : {4, 32})
        report["life"].push_back(costOf(cube, params(kAuflic, life)).processor);
    for (const int side : {64, 384})
        report["side"].push_back(costOf(analyticFlow({side, side, side}, 4), params(kAuflic)).processor);
    for (const std::size_t threads : {1, 2}) {
        const global_control limit(global_control::max_allowed_parallelism, threads);
        report["threads"].push_back(costOf(paper, params(kAuflic)).wall);
    }
    return report;
}

} // namespace
} // namespace vdblic::bench

int main()
{
    openvdb::initialize();
    std::printf("%s\n", vdblic::bench::measure().dump().c_str());
}
