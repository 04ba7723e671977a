#include "bench/engine/figures.h"

#include <cmath>
#include <cstdio>

namespace vdblic::bench {
namespace {

double mean(const std::vector<double>& values)
{
    double sum = 0;
    for (const double value : values)
        sum += value;
    return values.empty() ? std::nan("") : sum / double(values.size());
}

} // namespace

void printHeading(const char* title)
{
    std::printf(
        "\n%s\n\n| | ns per voxel and frame | load | scatter | convolve | filter | live | steps | deposits | hits "
        "| zero hits [%%] | temporal raw / smoothed | along | deviation "
        "|\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
        title);
}

nlohmann::json printRow(const std::string& name, const Figures& f)
{
    const auto per = [&](double amount) { return amount / f.voxels; };
    const auto live = double(f.stats.particles + f.stats.released);
    std::printf("| %-34s | %7.1f | %5.1f | %5.1f | %5.1f | %5.1f | %5.2f | %5.2f | %6.2f | %5.1f | %.2f | %.3f / %.3f "
                "| %4.1f | %.3f |\n",
                name.c_str(), f.nanoseconds, 1e9 * per(f.times.load), 1e9 * per(f.times.scatter),
                1e9 * per(f.times.convolve), 1e9 * per(f.times.filter), per(live), per(double(f.stats.steps)),
                per(double(f.stats.deposits)), per(double(f.stats.hits)), 100 * per(double(f.stats.emptyVoxels)),
                mean(f.temporal), mean(f.smoothed), mean(f.along), mean(f.deviation));
    std::fflush(stdout);
    return {{"name", name},
            {"ns_per_voxel", f.nanoseconds},
            {"wall_ns_per_voxel", f.wallNanoseconds},
            {"seconds",
             {{"load", f.times.load},
              {"scatter", f.times.scatter},
              {"convolve", f.times.convolve},
              {"filter", f.times.filter}}},
            {"live_per_voxel", per(live)},
            {"steps_per_voxel", per(double(f.stats.steps))},
            {"deposits_per_voxel", per(double(f.stats.deposits))},
            {"hits_per_voxel", per(double(f.stats.hits))},
            {"zero_hit_share", per(double(f.stats.emptyVoxels))},
            {"temporal", mean(f.temporal)},
            {"temporal_smoothed", mean(f.smoothed)},
            {"along_length", mean(f.along)},
            {"deviation", mean(f.deviation)}};
}

} // namespace vdblic::bench
