#include "vdblic/flow/reference_frame.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/index_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>

namespace vdblic {
namespace {

using openvdb::Mat3d;
using openvdb::Vec3d;
using openvdb::math::Transform;

constexpr const char *kVelocityKey = "frame_velocity", *kRotationKey = "frame_rotation", *kAxisKey = "frame_axis",
                     *kPointKey = "frame_point";
constexpr std::string_view kMean = "mean";
constexpr double kMost = 1e18;

Vec3d vectorOf(const std::array<double, 3>& numbers)
{
    return {numbers[0], numbers[1], numbers[2]};
}

/// The nearest whole numbers, if all are as near as the tolerance; else the numbers.
Vec3d wholeIfNear(const Vec3d& numbers, double tolerance)
{
    const Vec3d whole(std::round(numbers[0]), std::round(numbers[1]), std::round(numbers[2]));
    const Vec3d off = openvdb::math::Abs(numbers - whole);
    return std::max({off[0], off[1], off[2]}) <= tolerance ? whole : numbers;
}

/// The parameter `frame_velocity`: three numbers, or `mean`.
Parameter velocityParameter(ReferenceFrameParams& params)
{
    const auto read = [&params](const Words& words) {
        params.followsMean = words.size() == 1 && words[0] == kMean;
        params.velocity.reset();
        if (params.followsMean) return;
        std::array<double, 3> velocity{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::optional<double> number = words.size() == 3 ? detail::numberIn(words[axis]) : std::nullopt;
            if (!number || !(std::abs(*number) <= kMost))
                throw ParameterError("`frame_velocity` takes three finite numbers, or mean");
            velocity[axis] = *number;
        }
        params.velocity = velocity;
    };
    const auto write = [&params]() -> Words {
        if (params.followsMean) return {std::string(kMean)};
        return WordsOf<std::optional<std::array<double, 3>>>::write(params.velocity);
    };
    Parameter result = parameter("frame_velocity",
                                 "Velocity of an observer who moves along. Texture and `magnitude` are of the flow "
                                 "relative to the observer. Mean: the mean velocity of the first frame on disk.",
                                 WordType::kText, 1, read, write, {.unit = "world units/s", .words = "U V W or mean"});
    result.most = 3;
    return result;
}

} // namespace

Parameters parametersOf(ReferenceFrameParams& params)
{
    return {
        velocityParameter(params),
        parameter("frame_rotation", "Turns of an observer, right-handed about an axis, as in the frame of a rotor.",
                  params.rotation, {.unit = "turns/min", .words = "RPM", .limits = {-1e9, 1e9}}),
        parameter("frame_axis", "Axis of the observer's rotation; z by default.", params.axis,
                  {.words = "X Y Z", .limits = {-kMost, kMost}}),
        parameter("frame_point", "Point on that axis, which moves with the observer; the origin by default.",
                  params.point, {.words = "X Y Z", .limits = {-kMost, kMost}}),
        parameter("stay",
                  "Leave the textures in front of the observer, whom the world moves past. By default each is brought "
                  "back to its place in the world.",
                  params.stay),
    };
}

void ReferenceFrameParams::validate() const
{
    ReferenceFrameParams copy = *this;
    checkLimits(parametersOf(copy));
    const Parameter ofVelocity = velocityParameter(copy); // whose words are texts
    if (const Words words = ofVelocity.get(); !words.empty()) ofVelocity.set(words);
    if (stay && isAtRest())
        throw ParameterError("`stay` is of an observer who moves: give `frame_velocity` or `frame_rotation`");
    if (rotation == 0 && (axis || point))
        throw ParameterError("`frame_axis` and `frame_point` are of `frame_rotation`, which is not given");
    if (axis && !(vectorOf(*axis).length() > 0))
        throw ParameterError("`frame_axis` cannot be 0 0 0: give the direction of the axis");
}

ReferenceFrame::ReferenceFrame(const ReferenceFrameParams& params, const Transform& voxels)
    : mParams(params), mAxes(indexAxes(voxels)), mOrigin(voxels.indexToWorld(Vec3d(0))),
      mVelocity(vectorOf(params.velocity.value_or(std::array<double, 3>{}))),
      mPoint(vectorOf(params.point.value_or(std::array<double, 3>{})))
{
    const Vec3d axis = vectorOf(params.axis.value_or(std::array<double, 3>{0, 0, 1}));
    const Vec3d w = axis * (params.rotation * 2 * std::numbers::pi / 60 / axis.length());
    mSpin = Mat3d(0.0, -w[2], w[1], w[2], 0.0, -w[0], -w[1], w[0], 0.0);
}

ReferenceFrame::Pose ReferenceFrame::poseAt(double seconds) const
{
    const Vec3d way = mVelocity * seconds;
    if (mParams.rotation == 0) {
        constexpr double kWhole = 1e-4;
        return {Mat3d::identity(), mAxes * wholeIfNear(mAxes.inverse() * way, kWhole)};
    }
    const double rate = std::abs(mParams.rotation) * 2 * std::numbers::pi / 60, angle = rate * seconds;
    const Mat3d spin = mSpin * (1 / rate); // Rodrigues
    const Mat3d turn = Mat3d::identity() + spin * std::sin(angle) + spin * spin * (1 - std::cos(angle));
    return {turn, mPoint + way - turn * mPoint};
}

Transform::Ptr ReferenceFrame::moved(const Transform& transform, const Pose& pose) const
{
    auto result = transform.copy();
    if (mParams.rotation == 0) {
        result->postTranslate(pose.shift);
        return result;
    }
    openvdb::Mat4d rows = openvdb::Mat4d::identity(); // of row vectors
    rows.setMat3(pose.turn.transpose());
    rows.setTranslation(pose.shift);
    result->postMult(rows);
    return result;
}

Transform::Ptr ReferenceFrame::toWorld(const Transform& seen, double seconds) const
{
    return moved(seen, poseAt(seconds));
}

Transform::Ptr ReferenceFrame::fromWorld(const Transform& world, double seconds) const
{
    const Pose pose = poseAt(seconds);
    const Mat3d back = pose.turn.transpose();
    return moved(world, {back, -(back * pose.shift)});
}

IndexMap ReferenceFrame::toWorldVoxels(double seconds) const
{
    const Pose pose = poseAt(seconds);
    const Mat3d toIndex = mAxes.inverse();
    if (mParams.rotation != 0)
        return {toIndex * pose.turn * mAxes, toIndex * (pose.turn * mOrigin + pose.shift - mOrigin)};
    constexpr double kRounding = 1e-6;
    return {Mat3d::identity(), wholeIfNear(toIndex * pose.shift, kRounding)};
}

VelocityMap ReferenceFrame::seen(double seconds) const
{
    const Mat3d back = poseAt(seconds).turn.transpose();
    return {back, mSpin * -1.0, mSpin * mPoint - back * mVelocity};
}

VelocityMap ReferenceFrame::unseen(double seconds) const
{
    const Mat3d turn = poseAt(seconds).turn;
    return {turn, turn * mSpin, mVelocity - turn * (mSpin * mPoint)};
}

void ReferenceFrame::describe(openvdb::MetaMap& metadata) const
{
    const auto insert = [&](const char* key, const std::optional<std::array<double, 3>>& numbers) {
        if (numbers) metadata.insertMeta(key, openvdb::Vec3DMetadata(vectorOf(*numbers)));
    };
    insert(kVelocityKey, mParams.velocity);
    if (mParams.rotation == 0) return;
    metadata.insertMeta(kRotationKey, openvdb::DoubleMetadata(mParams.rotation));
    insert(kAxisKey, mParams.axis);
    insert(kPointKey, mParams.point);
}

ReferenceFrameParams ReferenceFrame::describedIn(const openvdb::MetaMap& metadata)
{
    const auto numbers = [&](const char* key) -> std::optional<std::array<double, 3>> {
        const auto found = metadata.getMetadata<openvdb::Vec3DMetadata>(key);
        if (!found) return std::nullopt;
        return std::array{found->value()[0], found->value()[1], found->value()[2]};
    };
    const auto rotation = metadata.getMetadata<openvdb::DoubleMetadata>(kRotationKey);
    return {.velocity = numbers(kVelocityKey),
            .rotation = rotation ? rotation->value() : 0,
            .axis = numbers(kAxisKey),
            .point = numbers(kPointKey)};
}

} // namespace vdblic
