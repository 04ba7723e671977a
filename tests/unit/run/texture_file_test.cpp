#include "vdblic/run/texture_file.h"

#include "lic/test_flow.h"
#include "vdblic/flow/flow_sequence.h"
#include "vdblic/run/advect_params.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

/// A frame of a flow that turns about the z axis, stored in units of half a world unit per second.
LoadedFrame turningFrame()
{
    LoadedFrame frame;
    frame.flow = test::makeFrames({Coord(-4, -4, 0), Coord(12, 12, 3)}, 1, [](const Coord& at, int) {
                     return Vec3f(float(-at[1]), float(at[0]), 0);
                 }).front();
    frame.flow.toWorldPerSecond = openvdb::Mat3d::identity() * 0.5;
    frame.velocity.values = frame.flow.velocities->deepCopy();
    frame.velocity.values->setTransform(openvdb::math::Transform::createLinearTransform(0.25));
    return frame;
}

std::vector<std::string> namesOf(const TextureFile& file)
{
    std::vector<std::string> names;
    for (const auto& grid : file.grids)
        names.push_back(grid->getName());
    return names;
}

TEST(TextureFile, HoldsEachGridOnItsTransform)
{
    LoadedFrame frame = turningFrame();
    const auto carried = openvdb::FloatGrid::create();
    carried->setName("smoke");
    frame.velocity.carried = {carried};
    AdvectParams params;
    params.textureName = "texture";
    params.derived = {"vorticity", "q"};
    const auto texture = std::make_shared<openvdb::FloatTree>(0.0f);
    texture->setValue({1, 2, 3}, 0.75f);
    const auto finer = openvdb::math::Transform::createLinearTransform(0.125);

    const TextureFile file = makeTextureFile(params, frame, texture, *finer, {5, 3.75, 1.5, 0.25});
    EXPECT_EQ(namesOf(file), (std::vector<std::string>{"texture", "magnitude", "vorticity", "q", "smoke"}));
    EXPECT_EQ(file.grids[0]->transform(), *finer);
    EXPECT_EQ(openvdb::gridConstPtrCast<openvdb::FloatGrid>(file.grids[0])->treePtr(), texture);
    for (const std::size_t other : {1, 2, 3})
        EXPECT_EQ(file.grids[other]->transform(), frame.velocity.values->transform()) << other;
    for (const std::size_t fog : {0, 1, 2, 3})
        EXPECT_EQ(file.grids[fog]->getGridClass(), openvdb::GRID_FOG_VOLUME) << fog;
}

TEST(TextureFile, MagnitudeIsInWorldUnitsPerSecond)
{
    const LoadedFrame frame = turningFrame();
    const auto transform = openvdb::math::Transform::createLinearTransform(0.25);
    const TextureFile file = makeTextureFile({}, frame, std::make_shared<openvdb::FloatTree>(0.0f), *transform, {});
    const auto magnitude = openvdb::gridConstPtrCast<openvdb::FloatGrid>(file.grids[1]);
    EXPECT_EQ(magnitude->activeVoxelCount(), frame.flow.domain->voxelCount());
    for (auto voxel = magnitude->cbeginValueOn(); voxel; ++voxel) {
        const Coord at = voxel.getCoord();
        ASSERT_FLOAT_EQ(*voxel, float(0.5 * std::hypot(at[0], at[1]))) << at;
    }
}

TEST(TextureFile, TellsItsTimeAndParameters)
{
    const LoadedFrame frame = turningFrame();
    const auto texture = std::make_shared<openvdb::FloatTree>(0.0f);
    const auto& transform = frame.velocity.values->transform();
    AdvectParams params;
    params.scatter.lifeSpan = 6;
    openvdb::MetaMap metadata = makeTextureFile(params, frame, texture, transform, {5, 3.75, 1.5, 0.25}).metadata;
    EXPECT_EQ(metadata.metaValue<std::int64_t>("frame"), 5);
    EXPECT_EQ(metadata.metaValue<double>("source_frame"), 3.75);
    EXPECT_EQ(metadata.metaValue<double>("time"), 1.5);
    EXPECT_EQ(metadata.metaValue<double>("dt"), 0.25);
    EXPECT_EQ(metadata.metaValue<std::string>("method"), "auflic");
    EXPECT_EQ(metadata.metaValue<std::int32_t>("life_span"), 6);
    EXPECT_EQ(metadata.metaValue<std::int32_t>("preroll"), 6);
    params.steady = LicKernel::kBox;
    metadata = makeTextureFile(params, frame, texture, transform, {}).metadata;
    EXPECT_EQ(metadata.metaValue<std::string>("method"), "lic");
    EXPECT_EQ(metadata.metaValue<std::string>("kernel"), "box");
    EXPECT_FALSE(metadata["sharpen"]); // steady LIC has no feedback
}

} // namespace
} // namespace vdblic
