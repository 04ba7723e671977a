#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/methods/ibfv/ibfv.h"
#include "vdblic/methods/lea/lea.h"
#include "vdblic/methods/lic/lic.h"
#include "vdblic/methods/streaks/streaks.h"
#include "vdblic/methods/ufac/ufac.h"
#include "vdblic/run/advect.h"

#include "distributed/thread_ranks.h"
#include "temporary_folder.h"
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3f;

using VelocityAt = std::function<std::optional<Vec3f>(const Coord&, int frame)>;

constexpr int kFrames = 4;

/// Velocities in voxels a frame, one file a frame.
void writeSequence(const TemporaryFolder& folder, const CoordBBox& box, const VelocityAt& velocity)
{
    for (int frame = 1; frame <= kFrames; ++frame) {
        auto grid = openvdb::Vec3SGrid::create(Vec3f(0));
        grid->setName("velocity");
        auto accessor = grid->getAccessor();
        for (auto voxel = box.begin(); voxel; ++voxel) {
            if (const auto value = velocity(*voxel, frame)) accessor.setValue(*voxel, *value);
        }
        writeVdb(folder / fmt::format("v.{:04}.vdb", frame), {grid}, {});
    }
}

/// A turning and drifting flow of some speed. @param speed voxels a frame
Vec3f turning(const Coord& at, int frame, float speed)
{
    const Vec3f v(float(std::sin(0.07 * at[1] + 0.3 * frame)), float(std::cos(0.05 * at[2])),
                  float(std::sin(0.06 * at[0] + 1)));
    return v * speed;
}

AdvectParams paramsIn(const TemporaryFolder& folder, const std::string& output)
{
    AdvectParams params;
    params.flow.input.pattern = folder / "v.%04d.vdb";
    params.output = folder / (output + ".%04d.vdb");
    params.flow.frameSpacing = 1;
    params.flow.velocity.unit = VelocityUnit::kVoxelPerFrame;
    params.preroll = 2;
    params.derived = {"vorticity", "hits"};
    return params;
}

/// Take a method that does not scatter.
void useWithoutHits(const TextureMethod* method, AdvectParams& params)
{
    params.texture.method = method;
    params.derived = {"vorticity"};
}

void drawLines(AdvectParams& params)
{
    useWithoutHits(&kStreaks, params);
    params.derived = {"vorticity", "q"};
    params.streaks.draw = StreakForm::kLines;
    params.streaks.spacing = {3, 3, 3};
}

std::string bytesOf(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void advectBy(int ranks, const AdvectParams& params)
{
    test::ThreadRanks(ranks).run([&](Exchange& exchange) {
        std::istringstream noLines;
        Reporter silent;
        advectSequence(params, noLines, silent, exchange);
    });
}

/// Check that several ranks write the bytes that one process writes.
void expectSameFiles(const TemporaryFolder& folder, const std::vector<int>& ranks,
                     const std::function<void(AdvectParams&)>& change)
{
    AdvectParams params = paramsIn(folder, "one");
    change(params);
    advectBy(1, params);
    for (const int number : ranks) {
        AdvectParams shared = paramsIn(folder, fmt::format("by{}", number));
        change(shared);
        advectBy(number, shared);
        const int textures = (kFrames - 1) * params.texture.substeps + 1;
        for (int frame = 1; frame <= textures; ++frame) {
            const std::string expected = bytesOf(folder / fmt::format("one.{:04}.vdb", frame));
            ASSERT_GT(expected.size(), 100u) << frame;
            EXPECT_TRUE(bytesOf(folder / fmt::format("by{}.{:04}.vdb", number, frame)) == expected)
                << number << " ranks, frame " << frame;
        }
    }
}

const auto kAsItIs = [](AdvectParams&) {};

TEST(Ranks, WriteTheBytesOfOneProcess)
{
    const TemporaryFolder folder;
    writeSequence(folder, {Coord(-20, -4, 0), Coord(43, 27, 30)},
                  [](const Coord& at, int frame) { return turning(at, frame, 3); });
    expectSameFiles(folder, {2, 3, 7}, kAsItIs);
    expectSameFiles(folder, {4}, [](AdvectParams& params) { params.texture.method = &kUflic; });
    expectSameFiles(folder, {3}, [](AdvectParams& params) { useWithoutHits(&kLic, params); });
    expectSameFiles(folder, {3}, [](AdvectParams& params) { params.texture.method = &kAuflic2004; });
    for (const TextureMethod* const method : {&kIbfv, &kLea, &kUfac})
        expectSameFiles(folder, {3, 5}, [&](AdvectParams& params) { useWithoutHits(method, params); });
    expectSameFiles(folder, {2}, [](AdvectParams& params) { params.texture.substeps = 3; });
}

TEST(Ranks, WriteTheBytesOfOneProcessWithRefinedTextures)
{
    const TemporaryFolder folder;
    writeSequence(folder, {Coord(-9, -4, 0), Coord(22, 12, 14)},
                  [](const Coord& at, int frame) { return turning(at, frame, 1.5f); });
    expectSameFiles(folder, {2, 5}, [](AdvectParams& params) { params.flow.domain.refinement.factors = {3, 2, 3}; });
    expectSameFiles(folder, {3}, [](AdvectParams& params) {
        params.flow.domain.refinement = {{2, 2, 2}, Interpolation::kCubic};
        params.format.scalars = ScalarVoxels::kTexture;
        params.texture.substeps = 2;
    });
}

TEST(Ranks, ReachBeyondTheirNeighbours)
{
    const TemporaryFolder folder;
    writeSequence(folder, {Coord(0, 0, 0), Coord(95, 15, 15)},
                  [](const Coord& at, int frame) { return turning(at, frame, 1) + Vec3f(40, 0, 0); });
    expectSameFiles(folder, {2, 6}, kAsItIs);
}

TEST(Ranks, ReachFartherNearAJet)
{
    const TemporaryFolder folder;
    writeSequence(folder, {Coord(0, 0, 0), Coord(127, 15, 15)}, [](const Coord& at, int frame) {
        const bool isJet = at[0] > 90 && at[1] < 8;
        return turning(at, frame, 1) + Vec3f(isJet ? -25.0f : 0.0f, 0, 0);
    });
    expectSameFiles(folder, {4, 7}, kAsItIs);
}

TEST(Ranks, WriteTheBytesOfOneProcessForDomainsOfAnyShape)
{
    const auto inBall = [](const Coord& at, const Coord& centre, int radius) {
        const Coord d = at - centre;
        return d.asVec3i().lengthSqr() < radius * radius;
    };
    const auto onlyIf = [](bool isIn, const Vec3f& value) { return isIn ? std::optional(value) : std::nullopt; };
    const std::vector<VelocityAt> flows = {
        // A ball that grows and moves.
        [=](const Coord& at, int frame) {
            return onlyIf(inBall(at, Coord(6 * frame, 0, 0), 10 + 3 * frame), turning(at, frame, 4));
        },
        // Pieces.
        [=](const Coord& at, int frame) {
            return onlyIf(inBall(at, Coord(-15, 0, 0), 7) || inBall(at, Coord(30, 4, 4), 9), turning(at, frame, 2));
        },
        // Nothing in one frame.
        [=](const Coord& at, int frame) {
            return onlyIf(frame != 2 && inBall(at, Coord(0, 0, 0), 12), turning(at, frame, 2));
        },
        // A sheet one voxel thick.
        [=](const Coord& at, int frame) { return onlyIf(at[2] == 3, turning(at, frame, 2)); },
        // One leaf at rest.
        [=](const Coord& at, int) { return onlyIf(CoordBBox(Coord(0), Coord(7)).isInside(at), Vec3f(0)); },
    };
    for (const VelocityAt& flow : flows) {
        const TemporaryFolder folder;
        writeSequence(folder, {Coord(-24, -22, -22), Coord(48, 22, 22)}, flow);
        expectSameFiles(folder, {2, 4}, kAsItIs);
        expectSameFiles(folder, {2, 4}, drawLines);
    }
}

/// Keeps the details that a run reports.
class Details : public Reporter {
  public:
    void detail(std::string_view message) override { text += fmt::format("{}\n", message); }
    std::string text;
};

/// The same flow in other conventions, each of which needs values beyond a rank's box.
TEST(Ranks, ReadStaggeredVelocitiesAndComponents)
{
    const TemporaryFolder folder;
    const CoordBBox box(Coord(-12, -4, 0), Coord(43, 19, 22));
    const auto flow = [](const Coord& at, int frame) { return turning(at, frame, 3); };
    writeSequence(folder, box, flow);
    for (int frame = 1; frame <= kFrames; ++frame) {
        const auto path = folder / fmt::format("v.{:04}.vdb", frame);
        const VdbFile file = readVdb(path);
        file.grids.front()->setGridClass(openvdb::GRID_STAGGERED);
        writeVdb(path, {file.grids.front()}, {});
    }
    expectSameFiles(folder, {2, 5}, kAsItIs);
    for (int frame = 1; frame <= kFrames; ++frame) {
        openvdb::GridCPtrVec components;
        for (int axis = 0; axis < 3; ++axis) {
            auto grid = openvdb::DoubleGrid::create(0);
            grid->setName(fmt::format("vel.{}", "xyz"[axis]));
            grid->setGridClass(openvdb::GRID_STAGGERED);
            auto accessor = grid->getAccessor();
            for (auto voxel = box.begin(); voxel; ++voxel)
                accessor.setValue(*voxel, flow(*voxel, frame)[axis]);
            components.push_back(grid);
        }
        writeVdb(folder / fmt::format("v.{:04}.vdb", frame), components, {});
    }
    expectSameFiles(folder, {3}, kAsItIs);
}

TEST(Ranks, CutADomainAnewThatMovesAway)
{
    const TemporaryFolder folder;
    writeSequence(folder, {Coord(-16, -16, -16), Coord(112, 16, 16)}, [](const Coord& at, int frame) {
        const openvdb::Vec3d d(0.5 * (at[0] - 24 * frame), at[1], at[2]); // longest along x
        const bool isIn = d.lengthSqr() < 11 * 11;
        return isIn ? std::optional(turning(at, frame, 4)) : std::nullopt;
    });
    expectSameFiles(folder, {2, 5}, kAsItIs);
    expectSameFiles(folder, {3}, [](AdvectParams& params) {
        params.texture.substeps = 2;
        params.flow.domain.refinement.factors = {2, 1, 1};
    });
    expectSameFiles(folder, {3}, [](AdvectParams& params) { useWithoutHits(&kLic, params); });
    expectSameFiles(folder, {3}, drawLines);

    AdvectParams params = paramsIn(folder, "told");
    params.keepCheckpoint = true;
    params.flow.input.frames = "1-3";
    std::string told;
    test::ThreadRanks(3).run([&](Exchange& exchange) {
        std::istringstream noLines;
        Details details;
        advectSequence(params, noLines, details, exchange);
        if (exchange.isFirst()) told = details.text;
    });
    EXPECT_NE(told.find("frame 2: cut anew among the ranks"), std::string::npos) << told;

    params.flow.input.frames.clear(); // the checkpoint is that of the new parts
    params.resume = true;
    params.keepCheckpoint = false;
    advectBy(2, params);
    AdvectParams one = paramsIn(folder, "one");
    one.restart = true;
    advectBy(1, one);
    for (int frame = 1; frame <= kFrames; ++frame) {
        EXPECT_TRUE(bytesOf(folder / fmt::format("told.{:04}.vdb", frame)) ==
                    bytesOf(folder / fmt::format("one.{:04}.vdb", frame)))
            << frame;
    }
}

TEST(Ranks, GoOnFromTheCheckpointOfAnyNumberOfRanks)
{
    const TemporaryFolder folder;
    writeSequence(folder, {Coord(-20, -4, 0), Coord(43, 27, 30)},
                  [](const Coord& at, int frame) { return turning(at, frame, 3); });
    advectBy(1, paramsIn(folder, "one"));
    AdvectParams params = paramsIn(folder, "part");
    params.keepCheckpoint = true;
    params.checkpointEvery = 1;
    const auto checkpointFiles = [&] {
        const std::filesystem::directory_iterator files(folder.path());
        return std::count_if(begin(files), end(files), [](const std::filesystem::directory_entry& file) {
            return file.path().filename().string().starts_with("checkpoint");
        });
    };
    const int ranks[] = {3, 1, 5};
    for (int frame = 2; frame <= kFrames; ++frame) { // each run ends a frame later
        params.flow.input.frames = fmt::format("1-{}", frame);
        params.resume = frame > 2;
        params.keepCheckpoint = frame < kFrames;
        const int number = ranks[frame - 2];
        advectBy(number, params);
        EXPECT_EQ(checkpointFiles(), !params.keepCheckpoint ? 0 : number == 1 ? 1 : 1 + number);
    }
    for (int frame = 1; frame <= kFrames; ++frame) {
        EXPECT_TRUE(bytesOf(folder / fmt::format("one.{:04}.vdb", frame)) ==
                    bytesOf(folder / fmt::format("part.{:04}.vdb", frame)))
            << frame;
    }
}

TEST(Ranks, RefuseADamagedFrameTogether)
{
    const TemporaryFolder folder;
    writeSequence(folder, {Coord(0, 0, 0), Coord(31, 15, 15)},
                  [](const Coord& at, int frame) { return turning(at, frame, 2); });
    std::filesystem::resize_file(folder / "v.0003.vdb", 3000);
    AdvectParams params = paramsIn(folder, "out");
    params.checkpointEvery = 1;
    EXPECT_THROW(advectBy(3, params), InputError);
    EXPECT_TRUE(std::filesystem::exists(folder / "out.0001.vdb"));
    EXPECT_FALSE(std::filesystem::exists(folder / "out.0003.vdb"));
    EXPECT_TRUE(std::filesystem::exists(folder / "checkpoint.out.vdb"));
}

} // namespace
} // namespace vdblic
