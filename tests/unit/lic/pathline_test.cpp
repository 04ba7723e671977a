#include "vdblic/lic/pathline.h"

#include "methods/test_flow.h"
#include "vdblic/core/errors.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/velocity_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

const openvdb::CoordBBox kBox({-16, -16, -8}, {16, 16, 8});

/// A field whose two levels are given in voxels per step.
struct TestField {
    std::vector<VelocityFrame> frames;
    VelocityField field;

    TestField(const openvdb::CoordBBox& box, const test::FlowFunction& flow) : frames(test::makeFrames(box, 2, flow))
    {
        const FlowStep step = test::stepFrom(frames, 0);
        field.build(step.start.domain, step.startVelocities(), step.endVelocities());
    }
};

struct Walk {
    Float4 position, slope;
};

Walk advanceOne(const VelocityField& field, Walk walk, const PathlineParams& params, PathBatch& batch)
{
    batch.lanes = 1;
    batch.position.setLane(0, walk.position);
    batch.slope.setLane(0, walk.slope);
    advancePaths(field, field.window({0, 0, 0}), params, batch);
    return {batch.position.lane(0), batch.slope.lane(0)};
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
        EXPECT_EQ(batch.segments.size(), 1u);
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
    // x' = 6 sin(πt), sampled by the frames and linear between them.
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
                  double(batch.segments.size()) * tolerance);
        EXPECT_GE(batch.segments.size(), 3u); // 24 voxels of arc
    }
}

TEST(Pathline, LanesDoNotSeeEachOther)
{
    const TestField turning(kBox, [](const Coord& at, int level) {
        return Vec3f(float(-0.9 * at[1] + level), float(1.1 * at[0]), 0.1f * float(at[0]));
    });
    PathBatch all, one;
    all.lanes = 255;
    std::array<Float4, kLanes> starts;
    for (int m = 0; m < kLanes; ++m) {
        starts[std::size_t(m)] = Float4{float(2 * m) - 7, float(m), 0.5f, 0};
        all.position.setLane(m, starts[std::size_t(m)]);
        all.slope.setLane(m, turning.field.sample(starts[std::size_t(m)], 0, Float4{}));
    }
    advancePaths(turning.field, Bricks::Window(), {}, all); // everything is elsewhere
    for (int m = 0; m < kLanes; ++m) {
        const Float4 start = starts[std::size_t(m)];
        const Walk alone = advanceOne(turning.field, {start, turning.field.sample(start, 0, Float4{})}, {}, one);
        const auto taken = std::count_if(all.segments.begin(), all.segments.end(),
                                         [&](const Segment& segment) { return segment.lanes >> m & 1; });
        ASSERT_EQ(std::size_t(taken), one.segments.size());
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_EQ(all.position.lane(m)[axis], alone.position[axis]);
    }
}

/// The samples of a batch's first particle: their voxels, and how many are early.
struct OneParticlesSamples {
    std::vector<PathSamples::Voxel> voxels;
    int early = 0;

    OneParticlesSamples(const TestField& field, const PathBatch& batch, float spacing, float until)
    {
        PathSamples samples;
        const Domain& domain = field.field.domain();
        const LeafWindow window(domain, {-8, 0, 0});
        samplePaths(batch, domain, window, spacing, until, samples);
        for (const PathSamples::Run& run : samples.runs) {
            for (int i = 0; i < run.count[0]; ++i)
                voxels.push_back(samples.find(samples.rows[run.firstRow + std::size_t(i)].voxel(0), window));
            early += run.early[0];
        }
    }
};

TEST(Pathline, SamplesAreEvenlySpacedAndCarryTheirTime)
{
    // Accelerating from 1 to 5 voxels per step along x: x(t) = t + 2 t².
    const TestField field(kBox, [](const Coord&, int level) { return Vec3f(level == 0 ? 1.0f : 5.0f, 0, 0); });
    PathBatch batch;
    const Float4 start = {-8, 0, 0, 0};
    advanceOne(field.field, {start, field.field.sample(start, 0, Float4{})}, {}, batch);
    const OneParticlesSamples samples(field, batch, 0.25f, 1);
    ASSERT_GE(samples.voxels.size(), 12u);
    EXPECT_EQ(std::size_t(samples.early), samples.voxels.size());
    // Samples are the middles of pieces of a quarter voxel: a third of them lies in each voxel between the path's ends.
    std::map<int, int> perVoxel;
    for (const PathSamples::Voxel& voxel : samples.voxels)
        ++perVoxel[field.field.domain().origin(std::size_t(voxel.leaf))[0] + LeafVoxel::at(voxel.offset).x];
    EXPECT_EQ(perVoxel.begin()->first, -8);
    EXPECT_NEAR(perVoxel[-7], double(samples.voxels.size()) / 3, 1);
    EXPECT_NEAR(perVoxel[-6], double(samples.voxels.size()) / 3, 1);
    // x(t) = −8 + t + 2 t² has gone half of its three voxels at t = (√13 − 1) / 4.
    const float halfway = (std::sqrt(13.0f) - 1) / 4;
    EXPECT_NEAR(OneParticlesSamples(field, batch, 0.25f, halfway).early, double(samples.voxels.size()) / 2, 1);
}

TEST(Pathline, FindsVoxelsOutsideTheWindow)
{
    const TestField field(kBox, [](const Coord&, int) { return Vec3f(7, 0, 0); });
    PathBatch batch;
    advanceOne(field.field, {Float4{-14, 0, 0, 0}, Float4{7, 0, 0, 0}}, {}, batch);
    PathSamples samples;
    const Domain& domain = field.field.domain();
    samplePaths(batch, domain, LeafWindow(domain, {8, 0, 0}), 1, 1, samples);
    ASSERT_EQ(samples.far.size(), std::size_t(samples.runs.at(0).count[0])); // the window begins at x = 0
    for (const PathSamples::Voxel& voxel : samples.far) {
        ASSERT_GE(voxel.leaf, 0);
        const int x = domain.origin(std::size_t(voxel.leaf))[0] + LeafVoxel::at(voxel.offset).x;
        EXPECT_GE(x, -14);
        EXPECT_LE(x, -7);
    }
}

TEST(Pathline, AtRestThereIsOneSample)
{
    const TestField still(kBox, [](const Coord&, int) { return Vec3f(0); });
    PathBatch batch;
    const Walk end = advanceOne(still.field, {Float4{3, 2, 1, 0}, Float4{}}, {}, batch);
    EXPECT_EQ(distance(end.position, 3, 2, 1), 0);
    ASSERT_EQ(batch.segments.size(), 1u);
    EXPECT_EQ(OneParticlesSamples(still, batch, 0.5f, 1).voxels.size(), 1u);
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
