#include "vdblic/noise/noise_file.h"

#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/noise/noise.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace vdblic {
namespace {

/// Records the finished outputs.
class NoiseRecorder : public Reporter {
  public:
    void finished(const std::filesystem::path& output) override { outputs.push_back(output); }
    std::vector<std::filesystem::path> outputs;
};

openvdb::FloatGrid::Ptr writtenNoise(const NoiseParams& params)
{
    NoiseRecorder recorder;
    makeNoiseFile(params, recorder);
    EXPECT_EQ(recorder.outputs, std::vector<std::filesystem::path>{params.output});
    const VdbFile file = readVdb(params.output);
    EXPECT_EQ(file.contents(), "noise (float)");
    return file.find<openvdb::FloatGrid>("noise");
}

void expectNoise(const openvdb::FloatGrid& grid, std::uint32_t seed)
{
    for (auto voxel = grid.cbeginValueOn(); voxel; ++voxel) {
        const openvdb::Coord at = voxel.getCoord();
        ASSERT_FLOAT_EQ(*voxel, float(noiseValue(at.x(), at.y(), at.z(), seed)) / 65535) << at;
    }
}

TEST(NoiseFile, HoldsTheNoiseOfABox)
{
    const TemporaryFolder folder;
    const auto noise = writtenNoise({folder / "n.vdb", "", BoxSize{20, 9, 33}, {}, 4000000000});
    ASSERT_TRUE(noise);
    EXPECT_EQ(noise->activeVoxelCount(), 20u * 9u * 33u);
    EXPECT_EQ(noise->voxelSize(), openvdb::Vec3d(kDefaultVoxelSize));
    expectNoise(*noise, 4000000000);
}

TEST(NoiseFile, HasTheTopologyOfAGridOfAnyType)
{
    const TemporaryFolder folder;
    const auto addVoxels = [](auto grid, const char* name) {
        grid->setName(name);
        grid->setTransform(openvdb::math::Transform::createLinearTransform(0.25));
        for (int i = -30; i < 30; ++i)
            grid->tree().setValueOn({i, i * i % 41, -3 * i});
        grid->tree().addTile(1, openvdb::Coord(800, 0, 0), grid->background(), true);
        return grid;
    };
    writeVdb(folder / "like.vdb",
             {addVoxels(openvdb::FloatGrid::create(), "float"), addVoxels(openvdb::DoubleGrid::create(), "double"),
              addVoxels(openvdb::Vec3SGrid::create(), "vec3s"), addVoxels(openvdb::Vec3DGrid::create(), "vec3d"),
              addVoxels(openvdb::BoolGrid::create(), "bool"), addVoxels(openvdb::MaskGrid::create(), "mask")},
             {});
    const std::string like = (folder / "like.vdb").string();
    for (const char* type : {"", ":float", ":double", ":vec3s", ":vec3d", ":bool", ":mask"}) {
        const auto noise = writtenNoise({folder / "n.vdb", like + type, std::nullopt, {}, 3});
        ASSERT_TRUE(noise) << type;
        EXPECT_EQ(noise->activeVoxelCount(), 60u + 512u) << type;
        EXPECT_EQ(noise->voxelSize(), openvdb::Vec3d(0.25)) << type;
        expectNoise(*noise, 3);
    }
}

TEST(NoiseFile, HasTheVoxelsOfARefinedTexture)
{
    const TemporaryFolder folder;
    const auto like = openvdb::FloatGrid::create();
    like->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    like->tree().setValueOn({-1, 5, 0});
    like->tree().addTile(1, openvdb::Coord(16, 0, 0), 0, true);
    writeVdb(folder / "like.vdb", {like}, {});
    const Refinement refinement{{3, 1, 2}};
    const auto noise = writtenNoise({folder / "n.vdb", (folder / "like.vdb").string(), std::nullopt, refinement, 4});
    ASSERT_TRUE(noise);
    EXPECT_EQ(noise->activeVoxelCount(), 6u * (1 + 512));
    EXPECT_TRUE(noise->tree().isValueOn({-3, 5, 0}) && noise->tree().isValueOn({-1, 5, 1}));
    EXPECT_TRUE(noise->tree().isValueOn({71, 7, 15}));
    EXPECT_EQ(noise->transform(), *refinement.refined(like->transform()));
    expectNoise(*noise, 4);
}

TEST(NoiseParams, WantExactlyOneSource)
{
    EXPECT_THROW((NoiseParams{"n.vdb", "", std::nullopt}).validate(), ParameterError);
    EXPECT_THROW((NoiseParams{"n.vdb", "a.vdb", BoxSize{1, 1, 1}}).validate(), ParameterError);
    EXPECT_THROW((NoiseParams{"n.vdb", "", BoxSize{1, 0, 1}}).validate(), ParameterError);
    EXPECT_THROW((NoiseParams{"n.vdb", "", BoxSize{1, 1, 1}, {{2, 1, 1}}}).validate(), ParameterError);
    EXPECT_THROW((NoiseParams{"n.vdb", "a.vdb", std::nullopt, {{2, 17, 1}}}).validate(), ParameterError);
    EXPECT_NO_THROW((NoiseParams{"n.vdb", "a.vdb", std::nullopt}).validate());
    EXPECT_NO_THROW((NoiseParams{"n.vdb", "", BoxSize{1, 1, 1}}).validate());
}

} // namespace
} // namespace vdblic
