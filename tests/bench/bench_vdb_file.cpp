#include "vdblic/io/vdb_assembly.h"
#include "vdblic/io/vdb_file.h"

#include <benchmark/benchmark.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/Compression.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

namespace {

constexpr int kSide = 256;
constexpr std::uint32_t kBlosc = openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK;

/// A dense cube in half floats.
template<typename ValueAt>
openvdb::FloatGrid::Ptr texture(const char* name, const ValueAt& valueAt)
{
    auto grid = openvdb::FloatGrid::create();
    grid->setName(name);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    grid->setSaveFloatAsHalf(true);
    grid->tree().denseFill({openvdb::Coord(0), openvdb::Coord(kSide - 1)}, 1.f, true);
    for (auto leaf = grid->tree().beginLeaf(); leaf; ++leaf) {
        for (auto voxel = leaf->beginValueOn(); voxel; ++voxel)
            voxel.setValue(valueAt(voxel.getCoord()));
    }
    return grid;
}

/// A texture file: noise, which hardly gets smaller, and a smooth magnitude.
openvdb::GridCPtrVec textureFile()
{
    openvdb::initialize();
    std::minstd_rand random;
    std::uniform_real_distribution<float> value;
    return {texture("density", [&](const openvdb::Coord&) { return value(random); }),
            texture("magnitude", [](const openvdb::Coord& at) { return std::sin(0.02f * float(at.x() + at.z())); })};
}

/// OpenVDB's writer of files, to a stream.
class OpenVdbWriter : public openvdb::io::Archive {
  public:
    OpenVdbWriter() { setCompression(kBlosc); }
    void writeFile(std::ostream& stream, const openvdb::GridCPtrVec& grids) const
    {
        write(stream, grids, /*seekable=*/true);
    }
};

/// Writes or reads the file, as this library or as OpenVDB does, with so many threads.
void setUp(benchmark::internal::Benchmark* benchmark)
{
    benchmark->ArgNames({"openvdb", "threads"})->ArgsProduct({{1, 0}, {1, 2}});
    benchmark->MeasureProcessCPUTime()->UseRealTime()->Unit(benchmark::kMillisecond);
}

void writeLeaves(benchmark::State& state)
{
    const openvdb::GridCPtrVec grids = textureFile();
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, std::size_t(state.range(1)));
    const auto path = std::filesystem::temp_directory_path() / "vdblic_bench_write.vdb";
    while (state.KeepRunning()) {
        std::ofstream stream(path, std::ios::binary);
        if (state.range(0) == 1) {
            OpenVdbWriter().writeFile(stream, grids);
        } else {
            vdblic::VdbAssembly(kBlosc).assemble(stream, grids, {});
        }
    }
    std::filesystem::remove(path);
}
BENCHMARK(writeLeaves)->Apply(setUp);

void readLeaves(benchmark::State& state)
{
    const auto path = std::filesystem::temp_directory_path() / "vdblic_bench_read.vdb";
    vdblic::writeVdb(path, textureFile(), {});
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, std::size_t(state.range(1)));
    while (state.KeepRunning()) {
        if (state.range(0) == 1) {
            std::ifstream stream(path, std::ios::binary);
            benchmark::DoNotOptimize(openvdb::io::Stream(stream, /*delayLoad=*/false).getGrids());
        } else {
            benchmark::DoNotOptimize(vdblic::readVdb(path));
        }
    }
    std::filesystem::remove(path);
}
BENCHMARK(readLeaves)->Apply(setUp);

} // namespace
