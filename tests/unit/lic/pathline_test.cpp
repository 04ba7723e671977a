#include "vdblic/lic/pathline.h"

#include "lic/test_flow.h"
#include "vdblic/core/errors.h"

#include <gtest/gtest.h>

#include <numbers>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

const openvdb::CoordBBox kBox({-16, -16, -8}, {16, 16, 8});

/// A field whose two levels are given in voxels per step.
struct TestField {
    std::vector<FlowFrame> frames;
    VelocityField field;

    TestField(const openvdb::CoordBBox& box, const test::FlowFunction& flow) : frames(test::makeFrames(box, 2, flow))
    {
        const FlowStep step = test::stepFrom(frames, 0);
        field.build(step.start.domain, {step.start.velocities->tree(), step.startToStep},
                    {step.end.velocities->tree(), step.endToStep});
    }
};

struct Walk {
    Float4 position, slope;
};

Walk advanceOne(const VelocityField& field, Walk walk, const PathlineParams& params, PathBatch& batch)
{
    batch.count = 1;
    batch.position[0] = walk.position;
    batch.slope[0] = walk.slope;
    advancePaths(field, params, batch);
    return {batch.position[0], batch.slope[0]};
}

double distance(Float4 a, double x, double y, double z)
{
    return std::hypot(a[0] - x, a[1] - y, a[2] - z);
}

/// Error after turning about the z axis with an angular velocity that grows linearly in time, in `steps` time steps of
/// one integration step each. Trilinear and linear in time, so only the integrator errs.
double turningError(int steps)
{
    const double first = 0.8, growth = 1.2, radius = 10; // over a total time of 1
    PathlineParams coarse;
    coarse.tolerance = 10;
    Walk walk{{float(radius), 0, 0, 0}, {}};
    PathBatch batch;
    for (int k = 0; k < steps; ++k) {
        const TestField turning(kBox, [&](const Coord& at, int level) {
            const double turn = (first + growth * (k + level) / steps) / steps; // radians per step
            return Vec3f(float(-turn * at[1]), float(turn * at[0]), 0);
        });
        walk.slope = turning.field.sample(walk.position, 0, Float4{});
        walk = advanceOne(turning.field, walk, coarse, batch);
        EXPECT_EQ(batch.path[0].size(), 1u);
    }
    const double angle = first + growth / 2;
    return distance(walk.position, radius * std::cos(angle), radius * std::sin(angle), 0);
}

TEST(Pathline, ConvergesWithFourthOrderOnATurningAcceleratingField)
{
    const double coarse = turningError(2), fine = turningError(4), finer = turningError(8);
    EXPECT_NEAR(std::log2(coarse / fine), 4, 0.4);
    EXPECT_NEAR(std::log2(fine / finer), 4, 0.4);
}

TEST(Pathline, ConvergesWithSecondOrderInTheFrameSpacing)
{
    // x' = 6 sin(πt): frames sample it, and between them it is taken as linear.
    const auto error = [](int steps) {
        Walk walk{{-10, 0, 0, 0}, {}};
        PathBatch batch;
        for (int k = 0; k < steps; ++k) {
            const TestField field(kBox, [&](const Coord&, int level) {
                return Vec3f(float(6 * std::sin(std::numbers::pi * (k + level) / steps) / steps), 0, 0);
            });
            walk.slope = field.field.sample(walk.position, 0, Float4{});
            walk = advanceOne(field.field, walk, {}, batch);
        }
        return std::abs(walk.position[0] - (-10 + 12 / std::numbers::pi));
    };
    EXPECT_NEAR(std::log2(error(4) / error(8)), 2, 0.2);
}

TEST(Pathline, KeepsTheErrorUnderTheTolerance)
{
    const TestField turning(kBox,
                            [](const Coord& at, int) { return Vec3f(float(-2.0 * at[1]), float(2.0 * at[0]), 0); });
    for (const float tolerance : {0.1f, 0.01f, 0.001f}) {
        PathlineParams params;
        params.tolerance = tolerance;
        PathBatch batch;
        const Float4 start = {12, 0, 0, 0};
        const Walk end = advanceOne(turning.field, {start, turning.field.sample(start, 0, Float4{})}, params, batch);
        EXPECT_LT(distance(end.position, 12 * std::cos(2.0), 12 * std::sin(2.0), 0),
                  double(batch.path[0].size()) * tolerance);
        EXPECT_GE(batch.path[0].size(), 3u); // 24 voxels of arc
    }
}

TEST(Pathline, LanesDoNotSeeEachOther)
{
    const TestField turning(kBox, [](const Coord& at, int level) {
        return Vec3f(float(-0.9 * at[1] + level), float(1.1 * at[0]), 0.1f * float(at[0]));
    });
    PathBatch all, one;
    all.count = kLanes;
    std::array<Float4, kLanes> starts;
    for (int m = 0; m < kLanes; ++m) {
        starts[std::size_t(m)] = Float4{float(2 * m) - 7, float(m), 0.5f, 0};
        all.position[std::size_t(m)] = starts[std::size_t(m)];
        all.slope[std::size_t(m)] = turning.field.sample(starts[std::size_t(m)], 0, Float4{});
    }
    advancePaths(turning.field, {}, all);
    for (std::size_t m = 0; m < kLanes; ++m) {
        const Walk alone =
            advanceOne(turning.field, {starts[m], turning.field.sample(starts[m], 0, Float4{})}, {}, one);
        ASSERT_EQ(all.path[m].size(), one.path[0].size());
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_EQ(all.position[m][axis], alone.position[axis]);
    }
}

TEST(Pathline, SamplesAreEvenlySpacedAndCarryTheirTime)
{
    // Accelerating from 1 to 5 voxels per step along x: x(t) = t + 2 t².
    const TestField field(kBox, [](const Coord&, int level) { return Vec3f(level == 0 ? 1.0f : 5.0f, 0, 0); });
    PathBatch batch;
    const Float4 start = {-8, 0, 0, 0};
    advanceOne(field.field, {start, field.field.sample(start, 0, Float4{})}, {}, batch);
    std::vector<float> times;
    std::vector<int> voxels;
    for (const Segment& segment : batch.path[0]) {
        visitSamples(segment, 0.25f, [&](const SampleBlock& block) {
            for (int i = 0; i < block.count; ++i) {
                times.push_back(block.time[i]);
                voxels.push_back(block.x[i]);
            }
            return true;
        });
    }
    ASSERT_GE(times.size(), 12u);
    EXPECT_GT(times.front(), 0);
    EXPECT_LT(times.back(), 1);
    double last = -8 - 0.125; // the first sample is the middle of the first piece
    for (std::size_t i = 0; i < times.size(); ++i) {
        const double t = times[i], x = -8 + t + 2 * t * t;
        EXPECT_NEAR(x - last, 0.25, 0.02);
        EXPECT_EQ(voxels[i], int(std::floor(x + 0.5)));
        last = x;
    }
}

TEST(Pathline, AtRestThereIsOneSample)
{
    const TestField still(kBox, [](const Coord&, int) { return Vec3f(0); });
    PathBatch batch;
    const Walk end = advanceOne(still.field, {Float4{3, 2, 1, 0}, Float4{}}, {}, batch);
    EXPECT_EQ(distance(end.position, 3, 2, 1), 0);
    ASSERT_EQ(batch.path[0].size(), 1u);
    int samples = 0;
    visitSamples(batch.path[0][0], 0.5f, [&](const SampleBlock& block) { return samples += block.count, true; });
    EXPECT_EQ(samples, 1);
}

TEST(Pathline, EndsAfterLeavingTheDomain)
{
    const TestField fast(kBox, [](const Coord&, int) { return Vec3f(200, 0, 0); });
    PathBatch batch;
    const Walk end = advanceOne(fast.field, {Float4{}, Float4{200, 0, 0, 0}}, {}, batch);
    EXPECT_GT(end.position[0], 16.5f);
    EXPECT_LE(end.position[0], 16.5f + 8); // it stops with the stride that crossed the rim
    EXPECT_EQ(end.position[1], 0);
}

TEST(Pathline, RefusesParametersOutOfRange)
{
    PathlineParams params;
    params.tolerance = 0;
    EXPECT_THROW(params.validate(), ParameterError);
    params = {};
    params.sampleSpacing = std::nanf("");
    EXPECT_THROW(params.validate(), ParameterError);
}

} // namespace
} // namespace vdblic
