#include "vdblic/lines/lines_between.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace vdblic {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
constexpr double kTail = 3, kInterval = 2; // frames
constexpr float kRound = 1e-6f;

/// A particle that moves along x by a voxel a frame, and is at 0 in the earlier one of two frames.
struct Particle {
    std::int32_t id = 7;
    double time = 0;      ///< of the frame
    double from = -99;    ///< time of its first point
    float bright = 1;     ///< opacity of its head
    float scalar = 0;     ///< at all points
    double spacing = 0.5; ///< of points
};

/// Add a tail with a point each half frame.
void add(const Particle& particle, Lines& lines)
{
    if (lines.scalars.empty()) lines.scalars = {{"q", {}}};
    const auto begin = std::uint32_t(lines.pointCount());
    for (int i = int(kTail / particle.spacing); i >= 0; --i) {
        const double age = i * particle.spacing;
        const double time = particle.time - age;
        if (time < particle.from) continue;
        const auto share = float(1 - age / kTail);
        lines.positions.emplace_back(float(time), 0.0f, float(particle.id));
        lines.opacities.push_back(particle.bright * share);
        lines.radii.push_back(1 + share);
        lines.ages.push_back(float(age));
        lines.scalars[0].values.push_back(particle.scalar);
    }
    lines.lines.push_back({particle.id, begin, std::uint32_t(lines.pointCount()), 2});
}

Lines linesOf(const std::vector<Particle>& particles)
{
    Lines lines;
    for (const Particle& particle : particles)
        add(particle, lines);
    return lines;
}

TEST(LinesBetween, AParticleMovesOnWithItsTail)
{
    const Lines before = linesOf({{}}), after = linesOf({{.time = kInterval, .spacing = 0.25}});
    for (const double share : {0.1, 0.5, 0.75}) {
        const Lines lines = linesBetween(before, after, share, kInterval);
        ASSERT_EQ(lines.lines.size(), 1u);
        EXPECT_EQ(lines.lines[0].id, 7);
        EXPECT_EQ(lines.lines[0].source, 2);
        EXPECT_EQ(lines.lines[0].end, lines.pointCount());
        const double time = share * kInterval;
        EXPECT_EQ(lines.ages.front(), float(kTail));
        EXPECT_EQ(lines.ages.back(), 0.0f);
        for (std::size_t i = 0; i < lines.pointCount(); ++i) {
            const auto age = double(lines.ages[i]);
            if (i > 0) {
                EXPECT_LT(lines.ages[i], lines.ages[i - 1]);
            }
            EXPECT_NEAR(lines.positions[i][0], time - age, kRound);
            EXPECT_NEAR(lines.opacities[i], 1 - age / kTail, kRound);
            EXPECT_NEAR(lines.radii[i], 2 - age / kTail, kRound);
        }
    }
}

TEST(LinesBetween, BrightnessAndScalarsChangeEvenly)
{
    const Lines before = linesOf({{.bright = 0.4f, .scalar = 1}});
    const Lines after = linesOf({{.time = kInterval, .bright = 0.8f, .scalar = 5}});
    const Lines lines = linesBetween(before, after, 0.25, kInterval);
    EXPECT_NEAR(lines.opacities.back(), 0.5f, kRound);
    for (const float value : lines.scalars[0].values)
        EXPECT_NEAR(value, 2.0f, kRound);
}

TEST(LinesBetween, ALineOfTheEarlierFrameFadesOutWhereItIs)
{
    const Lines lines = linesBetween(linesOf({{}}), linesOf({}), 0.25, kInterval);
    ASSERT_EQ(lines.lines.size(), 1u);
    EXPECT_NEAR(lines.positions.back()[0], 0.0f, kRound);
    EXPECT_NEAR(lines.ages.back(), 0.5f, kRound);
    EXPECT_NEAR(lines.opacities.back(), 0.75 * (1 - 0.5 / kTail), kRound);
    EXPECT_EQ(lines.opacities.front(), 0.0f);
}

TEST(LinesBetween, ALineOfTheLaterFrameFadesInOnceItIsThere)
{
    const Lines after = linesOf({{.time = kInterval, .from = 0.5}});
    EXPECT_TRUE(linesBetween(linesOf({}), after, 0.2, kInterval).lines.empty());
    const Lines lines = linesBetween(linesOf({}), after, 0.5, kInterval);
    ASSERT_EQ(lines.lines.size(), 1u);
    EXPECT_NEAR(lines.positions.front()[0], 0.5f, kRound);
    EXPECT_NEAR(lines.positions.back()[0], 1.0f, kRound);
    EXPECT_NEAR(lines.opacities.back(), 0.5f, kRound);
}

TEST(LinesBetween, LinesAreMatchedByTheirIds)
{
    const Lines before = linesOf({{.id = -5}, {.id = 2}, {.id = 4}});
    const Lines after =
        linesOf({{.id = -9, .time = kInterval}, {.id = 2, .time = kInterval}, {.id = 8, .time = kInterval}});
    std::vector<std::int32_t> ids;
    const Lines lines = linesBetween(before, after, 0.5, kInterval);
    for (const Lines::Line& line : lines.lines) {
        ids.push_back(line.id);
        EXPECT_EQ(lines.positions[line.begin][2], float(line.id));
        EXPECT_NEAR(lines.opacities[line.end - 1],
                    line.id == 2                  ? 1
                    : line.id > 4 || line.id < -5 ? 0.5
                                                  : 0.5 * 2 / kTail,
                    kRound);
    }
    EXPECT_EQ(ids, (std::vector<std::int32_t>{-9, -5, 2, 4, 8}));
}

TEST(LinesBetween, AnIdThatBeginsAnewIsAnotherParticle)
{
    const Lines lines = linesBetween(linesOf({{}}), linesOf({{.time = kInterval, .from = 0.5}}), 0.5, kInterval);
    ASSERT_EQ(lines.lines.size(), 2u);
    EXPECT_NEAR(lines.positions[lines.lines[0].end - 1][0], 0.0f, kRound);
    EXPECT_NEAR(lines.positions[lines.lines[1].begin][0], 0.5f, kRound);
}

TEST(LinesBetween, AScalarOfOneFrameIsKept)
{
    Lines before = linesOf({{.scalar = kNothing}}), after = linesOf({{.time = kInterval, .scalar = 3}});
    before.scalars.push_back({"heat", std::vector<float>(before.pointCount(), 6)});
    const Lines lines = linesBetween(before, after, 0.5, kInterval);
    ASSERT_EQ(lines.scalars.size(), 2u);
    EXPECT_EQ(lines.scalars[1].name, "heat");
    for (const Lines::Scalar& scalar : lines.scalars) {
        ASSERT_EQ(scalar.values.size(), lines.pointCount());
        for (const float value : scalar.values)
            EXPECT_EQ(value, scalar.name == "q" ? 3.0f : 6.0f);
    }
}

TEST(LinesBetween, NoLineAtAll)
{
    EXPECT_EQ(linesBetween({}, {}, 0.5, kInterval).pointCount(), 0u);
}

} // namespace
} // namespace vdblic
