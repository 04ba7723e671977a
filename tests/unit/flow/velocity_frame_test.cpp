#include "vdblic/flow/velocity_frame.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/vdb_file.h"

#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <limits>
#include <numbers>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::Mat4d;
using openvdb::Vec3d;
using openvdb::Vec3f;
using openvdb::Vec3SGrid;
using openvdb::math::Transform;

const CoordBBox kBox({-4, 2, -9}, {9, 11, 3});

/// A velocity that is linear in index space.
Vec3d linear(const Vec3d& p)
{
    return {0.5 + 0.25 * p[0] - 0.5 * p[1], -1 + 0.125 * p[1] + 0.5 * p[2], 2 - 0.25 * p[2] + 0.75 * p[0]};
}

Vec3d shifted(const Coord& at, int axis, double by)
{
    Vec3d p = at.asVec3d();
    p[axis] += by;
    return p;
}

template<typename GridT, typename Value>
typename GridT::Ptr makeGrid(const std::string& name, const CoordBBox& box, const Value& value)
{
    auto grid = GridT::create();
    grid->setName(name);
    auto accessor = grid->getAccessor();
    for (auto at = box.begin(); at; ++at)
        accessor.setValue(*at, value(*at));
    return grid;
}

class VelocityFile : public testing::Test {
  protected:
    void SetUp() override { openvdb::initialize(); }

    FrameFile write(const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata = {})
    {
        const std::filesystem::path path = mFolder / "v.0001.vdb";
        writeVdb(path, grids, metadata);
        return {1, path};
    }
    VelocityFrame read(const openvdb::GridCPtrVec& grids, const VelocityParams& params = {})
    {
        return readVelocity(write(grids), params);
    }
    std::string messageOf(const openvdb::GridCPtrVec& grids, const VelocityParams& params = {})
    {
        try {
            read(grids, params);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }

  private:
    TemporaryFolder mFolder;
};

Vec3SGrid::Ptr vectors(const std::string& name = "velocity")
{
    return makeGrid<Vec3SGrid>(name, kBox, [](const Coord& at) { return Vec3f(linear(at.asVec3d())); });
}

/// Component `axis` on the faces at index − ½.
double face(const Coord& at, int axis)
{
    return linear(shifted(at, axis, -0.5))[axis];
}

void expectLinear(const VelocityFrame& frame, const CoordBBox& box, double tolerance = 1e-6)
{
    for (auto at = box.begin(); at; ++at) {
        const Vec3d value = frame.values->tree().getValue(*at), expected = linear((*at).asVec3d());
        ASSERT_TRUE(frame.values->tree().isValueOn(*at)) << *at;
        ASSERT_LE((value - expected).length(), tolerance * (1 + expected.length())) << *at;
    }
}

CoordBBox withoutLast(CoordBBox box)
{
    return {box.min(), box.max().offsetBy(-1)};
}

TEST_F(VelocityFile, FindsAVectorGridByEachNameAndType)
{
    for (const char* name : {"velocity", "vel", "v", "wind"}) {
        const VelocityFrame frame =
            read({makeGrid<FloatGrid>("density", kBox, [](auto&) { return 1.0f; }), vectors(name)});
        EXPECT_EQ(frame.gridName, name);
        expectLinear(frame, kBox);
    }
    const auto wide =
        makeGrid<openvdb::Vec3DGrid>("velocity", kBox, [](const Coord& at) { return linear(at.asVec3d()); });
    wide->setTransform(Transform::createLinearTransform(0.5));
    expectLinear(read({wide}), kBox);
    EXPECT_EQ(read({wide}).values->voxelSize(), Vec3d(0.5));
    const auto half = vectors();
    half->setSaveFloatAsHalf(true);
    expectLinear(read({half}), kBox, 1e-3);
}

TEST_F(VelocityFile, FindsThreeScalarsByEachNamingPattern)
{
    for (const char* name : {"velocity", "vel", "v"}) {
        for (const char* joint : {".", "_", ""}) {
            openvdb::GridCPtrVec grids;
            for (int axis = 2; axis >= 0; --axis) { // in any order in the file
                grids.push_back(
                    makeGrid<FloatGrid>(std::string(name) + joint + "xyz"[axis], kBox,
                                        [&](const Coord& at) { return float(linear(at.asVec3d())[axis]); }));
            }
            expectLinear(read(grids), kBox);
        }
    }
}

TEST_F(VelocityFile, ComponentsThatWereDroppedForBeingZeroCountAsZero)
{
    const auto x = makeGrid<FloatGrid>("vel.x", kBox, [](auto&) { return 3.0f; });
    const auto empty = [](const char* name) {
        return makeGrid<FloatGrid>(name, CoordBBox(), [](auto&) { return 0.0f; });
    };
    const VelocityFrame frame = read({x, empty("vel.y"), empty("vel.z")});
    EXPECT_EQ(frame.values->activeVoxelCount(), kBox.volume());
    EXPECT_EQ(frame.values->tree().getValue({0, 5, 0}), Vec3f(3, 0, 0));
}

TEST_F(VelocityFile, TakesTheFirstOfSeveralAndSaysSo)
{
    const auto other = makeGrid<Vec3SGrid>("vel", kBox, [](auto&) { return Vec3f(9); });
    const VelocityFrame first = read({other, vectors()});
    EXPECT_EQ(first.gridName, "velocity");
    ASSERT_EQ(first.remarks.size(), 1u);
    EXPECT_NE(first.remarks[0].find("velocity, vel"), std::string::npos);
    const VelocityFrame chosen = read({other, vectors()}, {.grid = "vel"});
    EXPECT_EQ(chosen.values->tree().getValue({0, 5, 0}), Vec3f(9));
    EXPECT_TRUE(chosen.remarks.empty());
}

TEST_F(VelocityFile, SaysWhatTheFileHoldsWhenThereIsNoVelocity)
{
    EXPECT_NE(messageOf({makeGrid<FloatGrid>("density", kBox, [](auto&) { return 1.0f; })}).find("density (float)"),
              std::string::npos);
    EXPECT_NE(messageOf({vectors()}, {.grid = "wind"}).find("no velocity 'wind'"), std::string::npos);
}

TEST_F(VelocityFile, StaggeredVectorsAreExactOnALinearField)
{
    const auto grid = makeGrid<Vec3SGrid>("velocity", kBox, [](const Coord& at) {
        return Vec3f(float(face(at, 0)), float(face(at, 1)), float(face(at, 2)));
    });
    grid->setGridClass(openvdb::GRID_STAGGERED);
    const VelocityFrame frame = read({grid});
    EXPECT_EQ(frame.values->activeVoxelCount(), kBox.volume());
    expectLinear(frame, withoutLast(kBox));
    // At the rim the far face is missing, so the near one stands for both.
    const Coord rim = kBox.max();
    EXPECT_FLOAT_EQ(frame.values->tree().getValue(rim)[0], float(face(rim, 0)));
}

TEST_F(VelocityFile, StaggeredScalarsOnOneTransformAreExactOnALinearField)
{
    openvdb::GridCPtrVec grids;
    for (int axis = 0; axis < 3; ++axis) {
        const auto grid = makeGrid<FloatGrid>(std::string("vel.") + "xyz"[axis], kBox,
                                              [&](const Coord& at) { return float(face(at, axis)); });
        grid->setGridClass(openvdb::GRID_STAGGERED);
        grids.push_back(grid);
    }
    expectLinear(read(grids), withoutLast(kBox));
}

TEST_F(VelocityFile, FaceSampledScalarsWithShiftedTransformsAreExactEverywhere)
{
    openvdb::GridCPtrVec grids;
    const double size = 0.25;
    for (int axis = 0; axis < 3; ++axis) {
        CoordBBox faces = kBox;
        ++faces.max()[axis];
        const auto grid = makeGrid<FloatGrid>(std::string("vel.") + "xyz"[axis], faces,
                                              [&](const Coord& at) { return float(face(at, axis)); });
        const auto transform = Transform::createLinearTransform(size);
        Vec3d shift(7, 0, 0);
        shift[axis] -= size / 2;
        transform->postTranslate(shift);
        grid->setTransform(transform);
        grids.push_back(grid);
    }
    const VelocityFrame frame = read(grids);
    EXPECT_EQ(frame.values->activeVoxelCount(), kBox.volume());
    expectLinear(frame, kBox);
    EXPECT_TRUE(frame.values->indexToWorld(Vec3d(0)).eq(Vec3d(7, 0, 0), 1e-9));
}

TEST_F(VelocityFile, RefusesComponentsThatDoNotFitTogether)
{
    const auto scalar = [](const char* name) { return makeGrid<FloatGrid>(name, kBox, [](auto&) { return 1.0f; }); };
    const auto coarse = scalar("vel.y"), far = scalar("vel.y");
    coarse->setTransform(Transform::createLinearTransform(2.0));
    far->transform().postTranslate(Vec3d(0.25, 0, 0));
    EXPECT_NE(messageOf({scalar("vel.x"), coarse, scalar("vel.z")}).find("different voxels"), std::string::npos);
    EXPECT_NE(messageOf({scalar("vel.x"), far, scalar("vel.z")}).find("origins differ"), std::string::npos);
}

TEST_F(VelocityFile, TurnsWorldVelocitiesIntoVoxelsThroughAnyTransformWithRightAngles)
{
    struct Case {
        const char* name;
        std::function<void(Transform&)> make;
    };
    const Case cases[] = {
        {"scaled", [](Transform& t) { t.preScale(0.25); }},
        {"scaled per axis", [](Transform& t) { t.preScale(Vec3d(0.25, 2, 0.5)); }},
        {"translated", [](Transform& t) { t.postTranslate(Vec3d(100, -3, 7)); }},
        {"rotated",
         [](Transform& t) {
             t.preScale(Vec3d(0.25, 2, 0.5)), t.postRotate(0.7, openvdb::math::Z_AXIS),
                 t.postRotate(-0.4, openvdb::math::X_AXIS);
         }},
        {"mirrored", [](Transform& t) { t.preScale(Vec3d(-0.5, 0.5, 0.5)); }},
    };
    for (const Case& c : cases) {
        const auto grid = vectors();
        c.make(grid->transform());
        const VelocityFrame frame = read({grid});
        // A point moved by its velocity in world space moves by the voxels of the step in index space.
        const Vec3d velocity(0.3, -1.7, 0.9), at(3, 4, 5);
        const double interval = 0.2;
        const Vec3d moved = grid->worldToIndex(grid->indexToWorld(at) + velocity * interval);
        EXPECT_TRUE((frame.toVoxelsPerFrame(interval).matrix * velocity).eq(moved - at, 1e-9)) << c.name;
        EXPECT_TRUE((frame.toWorldPerSecond(interval).matrix * velocity).eq(velocity, 1e-12)) << c.name;
    }
}

TEST_F(VelocityFile, UnderstandsEveryUnit)
{
    const auto grid = vectors();
    grid->setTransform(Transform::createLinearTransform(0.5));
    const double interval = 0.1;
    const Vec3d stored(3, 0, 0);
    const auto voxels = [&](const char* unit, double scale = 1) {
        VelocityParams params;
        params.unit = valueOf<VelocityUnit>(unit);
        params.scale = scale;
        return (read({grid}, params).toVoxelsPerFrame(interval).matrix * stored)[0];
    };
    EXPECT_NEAR(voxels("world/s"), 3 / 0.5 * 0.1, 1e-12);
    EXPECT_NEAR(voxels("world/frame"), 3 / 0.5, 1e-12);
    EXPECT_NEAR(voxels("voxel/s"), 3 * 0.1, 1e-12);
    EXPECT_NEAR(voxels("voxel/frame"), 3, 1e-12);
    EXPECT_NEAR(voxels("voxel/frame", -2), -6, 1e-12);
    EXPECT_THROW((void)valueOf<VelocityUnit>("m/s"), ParameterError);
}

TEST_F(VelocityFile, RecognisesMantaflowUnlessGivenTheUnit)
{
    const auto grid = vectors();
    grid->setGridClass(openvdb::GRID_STAGGERED);
    grid->insertMeta("file_base_resolution", openvdb::Vec3IMetadata(openvdb::Vec3i(32, 32, 48)));
    grid->setTransform(Transform::createLinearTransform(0.0625));
    const VelocityFrame frame = read({grid});
    EXPECT_TRUE(frame.mantaflow);
    EXPECT_EQ(frame.remarks.size(), 1u);
    EXPECT_NEAR((frame.toVoxelsPerFrame(1.0 / 24).matrix * Vec3d(1, 0, 0))[0], 2.5 / 24, 1e-12);
    VelocityParams withUnit;
    withUnit.unit = VelocityUnit::kWorldPerSecond;
    EXPECT_NEAR((read({grid}, withUnit).toVoxelsPerFrame(1.0 / 24).matrix * Vec3d(1, 0, 0))[0], 16.0 / 24, 1e-12);
}

TEST_F(VelocityFile, RefusesShearFrustumAndVoxelsWithoutSize)
{
    const auto sheared = vectors();
    Mat4d shear = Mat4d::identity();
    shear[1][0] = 0.3;
    sheared->setTransform(Transform::createLinearTransform(shear));
    EXPECT_NE(messageOf({sheared}).find("velocity has a sheared transform"), std::string::npos);

    const auto frustum = vectors();
    frustum->setTransform(Transform::createFrustumTransform(openvdb::BBoxd(Vec3d(0), Vec3d(10)), 0.5, 10, 1));
    EXPECT_NE(messageOf({frustum}).find("velocity has a frustum transform"), std::string::npos);
}

TEST_F(VelocityFile, RefusesOrMendsValuesThatAreNotNumbers)
{
    const auto grid = vectors();
    grid->tree().setValue({1, 5, 1}, Vec3f(0, std::numeric_limits<float>::quiet_NaN(), 0));
    grid->tree().setValue({0, 5, 1}, Vec3f(std::numeric_limits<float>::infinity(), 0, 0));
    const std::string message = messageOf({grid});
    for (const char* part : {"grid velocity", "frame 1", "2 voxels", "[0, 5, 1]", "`non_finite` zero"}) {
        EXPECT_NE(message.find(part), std::string::npos) << message;
    }
    VelocityParams mend;
    mend.nonFinite = NonFinite::kZero;
    const VelocityFrame frame = read({grid}, mend);
    EXPECT_EQ(frame.values->tree().getValue({1, 5, 1}), Vec3f(0));
    EXPECT_EQ(frame.values->tree().getValue({0, 5, 1}), Vec3f(0));
    ASSERT_EQ(frame.remarks.size(), 1u);
    EXPECT_NE(frame.remarks[0].find("2 voxels"), std::string::npos);
}

TEST_F(VelocityFile, ReadsTimesFromTheGridOrTheFileInAnyNumberType)
{
    const auto grid = vectors();
    grid->insertMeta("time", openvdb::FloatMetadata(1.5f));
    grid->insertMeta("dt", openvdb::DoubleMetadata(0.25));
    EXPECT_EQ(read({grid}).time, 1.5);
    EXPECT_EQ(read({grid}).dt, 0.25);
    openvdb::MetaMap metadata;
    metadata.insertMeta("time", openvdb::Int32Metadata(3));
    metadata.insertMeta("creator", openvdb::StringMetadata("ignored: our writer sets its own"));
    const VelocityFrame frame = readVelocity(write({vectors()}, metadata), {});
    EXPECT_EQ(frame.time, 3);
    EXPECT_FALSE(frame.dt.has_value());
}

TEST_F(VelocityFile, CarriesOtherGridsAlong)
{
    const auto density = makeGrid<FloatGrid>("heat", kBox, [](auto&) { return 0.5f; });
    VelocityParams params;
    params.carry = {"heat"};
    const VelocityFrame frame = read({density, vectors()}, params);
    ASSERT_EQ(frame.carried.size(), 1u);
    EXPECT_EQ(frame.carried[0]->getName(), "heat");
    params.carry = {"fuel"};
    EXPECT_NE(messageOf({density, vectors()}, params).find("no grid 'fuel'"), std::string::npos);
}

TEST_F(VelocityFile, MeasuresTheLargestDisplacementInVoxelsAndTiles)
{
    const auto grid = Vec3SGrid::create();
    grid->setName("velocity");
    grid->sparseFill(CoordBBox({0, 0, 0}, {15, 15, 15}), Vec3f(3, 0, 4));
    grid->setTransform(Transform::createLinearTransform(0.5));
    EXPECT_NEAR(read({grid}).largestDisplacement(0.1), 1.0, 1e-6);
    grid->tree().setValue({20, 0, 0}, Vec3f(0, 0, -20));
    EXPECT_NEAR(read({grid}).largestDisplacement(0.1), 4.0, 1e-6);
}

} // namespace
} // namespace vdblic
