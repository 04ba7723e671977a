#include "vdblic/field/units.h"

#include "vdblic/distributed/partition.h"
#include "vdblic/field/domain.h"
#include "vdblic/field/position.h"
#include "vdblic/field/refinement.h"
#include "vdblic/field/velocities.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/flow/flow_step.h"
#include "vdblic/methods/auflic/accumulator.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

namespace vdblic {
namespace {

// What must not compile: numbers of one space or time where those of another are asked for, and writing to what is
// const.

template<template<Space> class Of>
constexpr bool kAreApart = !std::is_convertible_v<Of<Space::kTexture>, Of<Space::kVelocity>> &&
                           !std::is_convertible_v<Of<Space::kVelocity>, Of<Space::kTexture>> &&
                           !std::is_convertible_v<Of<Space::kTexture>, Of<Space::kWorld>> &&
                           !std::is_assignable_v<Of<Space::kTexture>&, Of<Space::kVelocity>>;
static_assert(kAreApart<Voxel> && kAreApart<VoxelBox> && kAreApart<Rim> && kAreApart<Lengths> && kAreApart<Position>);

template<template<Space, Per> class Of>
constexpr bool kAreApartInTime =
    !std::is_convertible_v<Of<Space::kVelocity, Per::kFrame>, Of<Space::kVelocity, Per::kStep>> &&
    !std::is_convertible_v<Of<Space::kVelocity, Per::kSecond>, Of<Space::kVelocity, Per::kFrame>> &&
    !std::is_convertible_v<Of<Space::kVelocity, Per::kStep>, Of<Space::kTexture, Per::kStep>> &&
    !std::is_convertible_v<Of<Space::kWorld, Per::kSecond>, Of<Space::kVelocity, Per::kSecond>>;
static_assert(kAreApartInTime<FromStored> && kAreApartInTime<Velocities> && kAreApartInTime<Speeds>);
static_assert(!std::is_convertible_v<openvdb::Mat3d, FromStored<Space::kVelocity, Per::kStep>>);
static_assert(!std::is_convertible_v<StoredSpeeds, Speeds<Space::kVelocity, Per::kStep>>);

template<Space kOfBox, Space kOfRim>
concept CanDilate = requires(const VoxelBox<kOfBox>& box, const Rim<kOfRim>& rim)
{
    dilated(box, rim);
};
static_assert(CanDilate<Space::kTexture, Space::kTexture> && !CanDilate<Space::kTexture, Space::kVelocity>);

template<Space kSpace>
concept HasCoarseVoxel = requires(const Refinement& refinement, const Voxel<kSpace>& voxel)
{
    refinement.coarse(voxel);
};
static_assert(HasCoarseVoxel<Space::kTexture> && !HasCoarseVoxel<Space::kVelocity>);

template<Space kSpace, Per kTime>
concept MakesField = requires(VelocityField& field, const FrameDomain& domain,
                              const Velocities<kSpace, kTime>& velocities)
{
    field.prepare(domain, velocities, velocities);
};
static_assert(MakesField<Space::kVelocity, Per::kStep> && !MakesField<Space::kVelocity, Per::kFrame> &&
              !MakesField<Space::kTexture, Per::kStep>);

template<typename Values>
using ElementOf = std::remove_pointer_t<decltype(std::declval<Values>()[std::size_t(0)])>;
static_assert(std::is_const_v<ElementOf<const LeafValues<float>&>> && !std::is_const_v<ElementOf<LeafValues<float>&>>);
static_assert(std::is_const_v<ElementOf<const Accumulator&>> && !std::is_const_v<ElementOf<Accumulator&>>);
static_assert(std::is_const_v<std::remove_reference_t<decltype(*std::declval<const LeafValues<float>&>().tree())>>);

/// Frames 0.2 s apart of a velocity stored in world units per second, on voxels of a quarter.
VelocityFrame quarterFrame()
{
    VelocityFrame frame;
    frame.values = openvdb::Vec3SGrid::create();
    frame.values->setTransform(openvdb::math::Transform::createLinearTransform(0.25));
    frame.domain.refinement.factors = {2, 2, 2};
    return frame;
}

TEST(Units, LeadFromStoredValuesToTheVoxelsOfAStep)
{
    const VelocityFrame frame = quarterFrame();
    const FlowStep step{.start = frame, .end = frame, .interval = 0.2, .substeps = 4};
    EXPECT_DOUBLE_EQ(frame.toWorldPerSecond(0.2).matrix(0, 0), 1);
    EXPECT_DOUBLE_EQ(frame.toVoxelsPerFrame(0.2).matrix(0, 0), 0.8);
    const FlowStep::Velocity perStep = step.startVelocities();
    EXPECT_DOUBLE_EQ(perStep.unit.matrix(0, 0), 0.2);
    EXPECT_DOUBLE_EQ(frame.domain.refinement.toTexture(perStep).unit.matrix(0, 0), 0.4);
    EXPECT_DOUBLE_EQ(step.seconds(), 0.05);
}

TEST(Units, PositionsGoBetweenIndexSpacesAndBack)
{
    const IndexSpaces spaces(quarterFrame().domain.refinement);
    const Position<Space::kVelocity> coarse = spaces.velocity({Float4{5, 0, -3, 0}}); // (f + 0.5) / 2 - 0.5
    EXPECT_FLOAT_EQ(coarse.at[0], 2.25f);
    EXPECT_FLOAT_EQ(coarse.at[1], -0.25f);
    EXPECT_FLOAT_EQ(coarse.at[2], -1.75f);
    EXPECT_FLOAT_EQ(spaces.texture(coarse).at[0], 5);
}

} // namespace
} // namespace vdblic
