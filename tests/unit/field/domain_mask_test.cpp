#include "vdblic/field/domain_mask.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/vdb_file.h"

#include "temporary_folder.h"

#include <gtest/gtest.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <cstddef>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3d;
using openvdb::math::Transform;

const CoordBBox kBox({-10, -10, -10}, {20, 13, 9});

openvdb::MaskTree::Ptr everything()
{
    auto topology = std::make_shared<openvdb::MaskTree>();
    topology->fill(kBox, true);
    return topology;
}

std::shared_ptr<const Domain> cut(const DomainParams& params,
                                  const Transform& transform = *Transform::createLinearTransform())
{
    return makeDomain(everything(), transform, params, 7).texture;
}

class MaskFile : public testing::Test {
  protected:
    void SetUp() override { openvdb::initialize(); }

    std::string write(const std::string& name, const openvdb::GridCPtrVec& grids)
    {
        writeVdb(mFolder / name, grids, {});
        return (mFolder / name).string();
    }
    TemporaryFolder mFolder;
};

TEST(MakeDomain, WithoutParametersIsEveryActiveVoxel)
{
    EXPECT_EQ(cut({})->voxelCount(), kBox.volume());
}

TEST(MakeDomain, CutsByABoxOfVoxels)
{
    DomainParams params;
    params.box = {-3, 0, 2, 100, 0, 5};
    EXPECT_EQ(cut(params)->voxelCount(), std::size_t(24 * 1 * 4));
    params.box = {50, 50, 50, 60, 60, 60};
    EXPECT_EQ(cut(params)->voxelCount(), 0u);
    params.box = {5, 0, 0, 4, 0, 0};
    EXPECT_THROW(params.validate(), ParameterError);
}

TEST(MakeDomain, CutsByABoxOfTheWorldAroundVoxelCentres)
{
    const auto transform = Transform::createLinearTransform(0.5);
    transform->postTranslate(Vec3d(10, 0, 0));
    DomainParams params;
    params.worldBox = {10.0, -0.2, -0.7, 11.0, 0.2, 0.6}; // x 0…2, y 0, z −1…1
    EXPECT_EQ(cut(params, *transform)->voxelCount(), std::size_t(3 * 1 * 3));
    transform->postRotate(0.5, openvdb::math::Z_AXIS);
    std::size_t expected = 0;
    for (auto at = kBox.begin(); at; ++at) {
        const Vec3d p = transform->indexToWorld(*at);
        expected += p[0] >= 5 && p[0] <= 9 && p[1] >= 2 && p[1] <= 7 && p[2] >= -1 && p[2] <= 1;
    }
    params.worldBox = {5, 2, -1, 9, 7, 1};
    ASSERT_GT(expected, 100u);
    EXPECT_EQ(cut(params, *transform)->voxelCount(), expected);
}

TEST(MakeDomain, ExpandsTilesOnlyInsideTheBox)
{
    auto topology = std::make_shared<openvdb::MaskTree>();
    topology->addTile(2, Coord(0, 0, 0), true, true); // 4096³ voxels
    DomainParams params;
    params.box = {100, 100, 100, 109, 109, 109};
    EXPECT_EQ(makeDomain(topology, *Transform::createLinearTransform(), params, 1).texture->voxelCount(), 1000u);
}

TEST_F(MaskFile, CutsByEveryTypeThatMasks)
{
    const CoordBBox inside({0, 0, 0}, {4, 4, 4});
    const auto check = [&](auto grid, auto in, auto out, const char* type) {
        grid->setName("mask");
        auto values = grid->getAccessor();
        for (auto at = kBox.begin(); at; ++at)
            values.setValue(*at, inside.isInside(*at) ? in : out);
        DomainParams params;
        params.mask = write("mask.vdb", {grid});
        EXPECT_EQ(cut(params)->voxelCount(), inside.volume()) << type;
    };
    check(openvdb::FloatGrid::create(), 0.1f, 0.0f, "float");
    check(openvdb::DoubleGrid::create(), 2.0, -1.0, "double");
    check(openvdb::Int32Grid::create(), 1, 0, "int32");
    check(openvdb::Int64Grid::create(), std::int64_t(1), std::int64_t(-1), "int64");
    check(openvdb::BoolGrid::create(), true, false, "bool");

    const auto mask = openvdb::MaskGrid::create();
    mask->fill(inside, true);
    DomainParams params;
    params.mask = write("mask.vdb", {mask});
    EXPECT_EQ(cut(params)->voxelCount(), inside.volume());

    const auto vectors = openvdb::Vec3SGrid::create();
    params.mask = write("mask.vdb", {vectors});
    EXPECT_THROW(cut(params), InputError);
}

TEST_F(MaskFile, OfALevelSetTheInsideCountsAcrossTransforms)
{
    // A sphere around (1, 2, 0) of radius 3 in world space, on voxels finer than the velocity's.
    const auto sphere = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(3.0f, openvdb::Vec3f(1, 2, 0), 0.2f);
    sphere->setName("surface");
    DomainParams params;
    params.mask = write("mask.vdb", {openvdb::FloatGrid::create(), sphere}) + ":surface";
    const auto domain = cut(params, *Transform::createLinearTransform(0.5));
    EXPECT_NEAR(double(domain->voxelCount()), 4.0 / 3 * 3.14159 * 27 / 0.125, 45);
    EXPECT_TRUE(domain->topology().isValueOn({2, 4, 0}));
}

TEST_F(MaskFile, OfASequenceTheFrameCounts)
{
    const auto mask = openvdb::MaskGrid::create();
    mask->fill(CoordBBox({0, 0, 0}, {1, 0, 0}), true);
    write("mask.0007.vdb", {mask});
    DomainParams params;
    params.mask = (mFolder / "mask.%04d.vdb").string();
    EXPECT_EQ(cut(params)->voxelCount(), 2u);
    EXPECT_THROW((void)makeDomain(everything(), *Transform::createLinearTransform(), params, 8), InputError);
    params.mask += ":other";
    EXPECT_THROW(cut(params), InputError);
}

} // namespace
} // namespace vdblic
