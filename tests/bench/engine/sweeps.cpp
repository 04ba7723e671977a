#include "bench/engine/sweeps.h"

#include "bench/engine/methods.h"
#include "vdblic/field/box_domain.h"

#include <openvdb/openvdb.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <numbers>
#include <string>

namespace vdblic::bench {
namespace {

/// A ball of active voxels in a box. @param share of the box, about
std::shared_ptr<const Domain> ball(const BoxSize& size, double share)
{
    const openvdb::Vec3d centre(size[0] / 2.0, size[1] / 2.0, size[2] / 2.0);
    const double radius = std::cbrt(share * size[0] * size[1] * size[2] * 3 / (4 * std::numbers::pi));
    auto topology = std::make_shared<openvdb::MaskTree>();
    openvdb::tree::ValueAccessor<openvdb::MaskTree> voxels(*topology);
    for (int x = 0; x < size[0]; ++x) {
        for (int y = 0; y < size[1]; ++y) {
            for (int z = 0; z < size[2]; ++z) {
                if ((openvdb::Vec3d(x, y, z) - centre).length() < radius) voxels.setValueOn({x, y, z});
            }
        }
    }
    return std::make_shared<const Domain>(topology);
}

} // namespace

nlohmann::json sweepParameters()
{
    nlohmann::json rows;
    const TextureParams standard;
    printHeading("By life span, 96 x 96 x 96, 6 frames");
    const BoxSize cube{96, 96, 96};
    const Flow flow = analyticFlow(cube, 7, boxDomain(cube));
    for (const int life : {4, 8, 16, 32}) {
        TextureParams params;
        params.lifeSpan = life;
        rows.push_back(printRow("life span " + std::to_string(life), runPipeline(flow, params, false)));
    }
    printHeading("By size, 3 frames");
    for (const int side : {64, 128, 256, 384}) {
        const BoxSize size{side, side, side};
        rows.push_back(printRow(std::to_string(side) + " cubed",
                                runPipeline(analyticFlow(size, 4, boxDomain(size)), standard, false)));
    }
    printHeading("By share of active voxels, a ball in 192 x 192 x 192, 3 frames");
    const BoxSize box{192, 192, 192};
    for (const double share : {1.0, 0.25, 0.05}) {
        const auto domain = share == 1 ? boxDomain(box) : ball(box, share);
        rows.push_back(printRow(std::to_string(int(100 * share)) + " %",
                                runPipeline(analyticFlow(box, 4, domain), standard, false)));
    }
    printHeading("By threads, 144 x 73 x 81, 6 frames (wall time in the JSON and here)");
    const BoxSize paper{144, 73, 81};
    const Flow paperFlow = analyticFlow(paper, 7, boxDomain(paper));
    double one = 0;
    for (const std::size_t threads : {1, 2}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        const Figures figures = runPipeline(paperFlow, standard, false);
        rows.push_back(printRow(std::to_string(threads) + " threads", figures));
        if (threads == 1) one = figures.wallNanoseconds;
        std::printf("wall: %.1f ns per voxel and frame, speed-up %.2f\n", figures.wallNanoseconds,
                    one / figures.wallNanoseconds);
    }
    return rows;
}

} // namespace vdblic::bench
