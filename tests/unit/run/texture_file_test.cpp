#include "vdblic/run/texture_file.h"

#include "methods/test_flow.h"
#include "vdblic/flow/velocity_sequence.h"
#include "vdblic/methods/lic/lic.h"
#include "vdblic/run/advect_plan.h"
#include "vdblic/run/texture_run.h"

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
VelocityFrame turningFrame()
{
    VelocityFrame frame = test::makeFrames({Coord(-4, -4, 0), Coord(12, 12, 3)}, 1, [](const Coord& at, int) {
                              return Vec3f(float(-at[1]), float(at[0]), 0);
                          }).front();
    frame.values->setTransform(openvdb::math::Transform::createLinearTransform(0.25));
    frame.scale = 0.5;
    frame.sourceFrame = 3.75;
    return frame;
}

/// Its texture at 1.5 s, between frames a second apart, with four substeps.
TextureFrame turningTexture()
{
    const VelocityFrame frame = turningFrame();
    TextureFrame made(FlowStep{.start = frame, .end = frame, .substeps = 4, .substep = 3, .time = 1.5});
    made.texture = {*made.domain, 0.75f};
    return made;
}

std::vector<std::string> namesOf(const TextureFile& file)
{
    std::vector<std::string> names;
    for (const auto& grid : file.grids)
        names.push_back(grid->getName());
    return names;
}

/// Made by a process alone.
TextureFile textureFile(const AdvectPlan& plan, TextureFrame& made, std::int64_t number)
{
    OneProcess alone;
    return makeTextureFile(plan, made, number, alone, 0);
}

TEST(TextureFile, HoldsEachGridOnItsTransform)
{
    TextureFrame made = turningTexture();
    const auto carried = openvdb::FloatGrid::create();
    carried->setName("smoke");
    made.frame.carried = {carried};
    made.frame.domain.refinement.factors = made.refinement.factors = {2, 2, 2};
    AdvectParams params;
    params.textureName = "texture";
    params.derived = {"vorticity", "q"};
    params.finish = 0;
    made.hits = LeafValues<std::int32_t>(*made.domain, 3);
    const auto texture = made.texture.tree();
    const openvdb::math::Transform::Ptr finer = made.frame.textureTransform();

    const TextureFile file = textureFile(resolve(params), made, 5);
    EXPECT_EQ(namesOf(file), (std::vector<std::string>{"texture", "hits", "magnitude", "vorticity", "q", "smoke"}));
    EXPECT_EQ(file.grids[0]->transform(), *finer);
    EXPECT_EQ(openvdb::gridConstPtrCast<openvdb::FloatGrid>(file.grids[0])->treePtr(), texture);
    EXPECT_EQ(file.grids[1]->transform(), *finer);
    EXPECT_EQ(openvdb::gridConstPtrCast<openvdb::Int32Grid>(file.grids[1])->treePtr(), made.hits.tree());
    EXPECT_EQ(file.onTexture, 2u);
    for (const std::size_t other : {2, 3, 4})
        EXPECT_EQ(file.grids[other]->transform(), made.frame.values->transform()) << other;
    for (const std::size_t fog : {0, 2, 3, 4})
        EXPECT_EQ(file.grids[fog]->getGridClass(), openvdb::GRID_FOG_VOLUME) << fog;
}

TEST(TextureFile, MagnitudeIsInWorldUnitsPerSecond)
{
    TextureFrame made = turningTexture();
    const TextureFile file = textureFile(resolve({}), made, 1);
    const auto magnitude = openvdb::gridConstPtrCast<openvdb::FloatGrid>(file.grids[1]);
    EXPECT_EQ(magnitude->activeVoxelCount(), made.frame.domain.velocity->voxelCount());
    for (auto voxel = magnitude->cbeginValueOn(); voxel; ++voxel) {
        const Coord at = voxel.getCoord();
        ASSERT_FLOAT_EQ(*voxel, float(0.5 * std::hypot(at[0], at[1]))) << at;
    }
}

TEST(TextureFile, TellsItsTimeAndParameters)
{
    TextureFrame made = turningTexture();
    AdvectParams params;
    params.texture.lifeSpan = 6;
    params.texture.substeps = 4;
    openvdb::MetaMap metadata = textureFile(resolve(params), made, 5).metadata;
    EXPECT_EQ(metadata.metaValue<std::int64_t>("frame"), 5);
    EXPECT_EQ(metadata.metaValue<double>("source_frame"), 3.75);
    EXPECT_EQ(metadata.metaValue<double>("time"), 1.5);
    EXPECT_EQ(metadata.metaValue<double>("dt"), 0.25);
    EXPECT_EQ(metadata.metaValue<std::string>("method"), "auflic");
    EXPECT_EQ(metadata.metaValue<std::int32_t>("life_span"), 6);
    EXPECT_EQ(metadata.metaValue<std::int32_t>("preroll"), 6);
    params.texture.method = &kLic;
    made = turningTexture();
    metadata = textureFile(resolve(params), made, 5).metadata;
    EXPECT_EQ(metadata.metaValue<std::string>("method"), "lic");
    EXPECT_FALSE(metadata["sharpen"]); // steady LIC has no feedback
}

} // namespace
} // namespace vdblic
