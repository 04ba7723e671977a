#include "vdblic/io/affine_rows.h"

#include <gtest/gtest.h>
#include <openvdb/io/io.h>

#include <sstream>

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

/// As a damaged file may have them: OpenVDB refuses to make such a map, but not to read it.
TEST(AffineRows, AreThoseOfFlatVoxels)
{
    openvdb::initialize();
    const double flat = 4.7e-303;
    std::stringstream stored;
    openvdb::io::setCurrentVersion(stored);
    openvdb::writeString(stored, "ScaleMap");
    for (const double side :
         {flat, flat, 1 / flat, 1 / flat, 1 / flat}) { // sides, their inverses and what is made of them
        const openvdb::Vec3d sides(1, side, 1);
        stored.write(reinterpret_cast<const char*>(sides.asPointer()), sizeof sides);
    }
    const Transform::Ptr transform = Transform::createLinearTransform(1.0);
    transform->read(stored);
    EXPECT_EQ(affineRows(*transform)(1, 1), flat);
    EXPECT_THROW((void)transform->baseMap()->getAffineMap(), openvdb::ArithmeticError);
}

} // namespace
} // namespace vdblic
