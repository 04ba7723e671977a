#include "vdblic/compare/compare.h"

#include <benchmark/benchmark.h>
#include <openvdb/openvdb.h>

#include <cmath>

namespace {

constexpr int kSize = 256;

/// A dense cube of values that differ from voxel to voxel, plus `shift` in every voxel.
template<typename GridT>
typename GridT::Ptr cube(float shift)
{
    using Value = typename GridT::ValueType;
    openvdb::initialize();
    const openvdb::CoordBBox box(openvdb::Coord(0), openvdb::Coord(kSize - 1));
    auto grid = GridT::create();
    grid->tree().denseFill(box, Value(1.f), true);
    grid->tree().voxelizeActiveTiles();
    for (auto leaf = grid->tree().beginLeaf(); leaf; ++leaf) {
        auto* values = leaf->buffer().data();
        for (int n = 0; n < 512; ++n)
            values[n] = Value(std::sin(float(n + leaf->origin().x())) + shift);
    }
    return grid;
}

template<typename GridT>
void compareCubes(benchmark::State& state)
{
    const auto a = cube<GridT>(0), b = cube<GridT>(state.range(0) != 0 ? 0.25f : 0.f);
    while (state.KeepRunning())
        benchmark::DoNotOptimize(vdblic::compareGrids(*a, *b));
    state.SetItemsProcessed(state.iterations() * kSize * kSize * kSize); // voxels
}

BENCHMARK_TEMPLATE(compareCubes, openvdb::FloatGrid)
    ->ArgName("different")
    ->Arg(0)
    ->Arg(1)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(compareCubes, openvdb::Vec3SGrid)
    ->ArgName("different")
    ->Arg(0)
    ->Arg(1)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

} // namespace
