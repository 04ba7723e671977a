#include "vdblic/io/affine_rows.h"

#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/vdb_file.h"

#include <gtest/gtest.h>

namespace vdblic {
namespace {

using openvdb::math::Transform;

TEST(AffineRows, AreThoseOfOpenVDB)
{
    const Transform::Ptr turned = Transform::createLinearTransform(0.3);
    turned->postRotate(0.7, openvdb::math::Y_AXIS);
    turned->postTranslate(openvdb::Vec3d(1.1, -2.3, 0.7));
    const Transform::Ptr scaled = Transform::createLinearTransform(0.1);
    scaled->postScale(openvdb::Vec3d(1, 2, 3));
    scaled->postTranslate(openvdb::Vec3d(0.1, 0.2, 0.3));
    for (const Transform::Ptr& transform : {turned, scaled, Transform::createLinearTransform(0.1)})
        EXPECT_EQ(affineRows(*transform), transform->baseMap()->getAffineMap()->getMat4());
}

/// OpenVDB has no affine map of voxels smaller than some 1e-5, those of a microscope.
TEST(AffineRows, TakeVoxelsOfAnySize)
{
    const TemporaryFolder folder;
    for (const double size : {1e-9, 1e-5, 1e9}) {
        const auto grid = openvdb::FloatGrid::create();
        grid->setTransform(Transform::createLinearTransform(size));
        grid->tree().setValueOn({1, 2, 3}, 1);
        EXPECT_EQ(affineRows(grid->transform())(1, 1), size);
        writeVdb(folder / "a.vdb", {grid}, {});
        EXPECT_EQ(readVdb(folder / "a.vdb").grids.size(), 1u);
    }
}

TEST(AffineRows, FlatVoxelsAreRefused)
{
    const TemporaryFolder folder;
    const auto grid = openvdb::FloatGrid::create();
    grid->setTransform(
        std::make_shared<Transform>(std::make_shared<openvdb::math::ScaleMap>(openvdb::Vec3d(1, 4.7e-300, 1))));
    writeVdb(folder / "a.vdb", {grid}, {});
    EXPECT_THROW((void)readVdb(folder / "a.vdb"), InputError);
}

} // namespace
} // namespace vdblic
