#include "view/line_packet.h"

#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/lines/line_grid.h"
#include "view/viewer.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace vdblic::view {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
const auto kHalf = openvdb::math::Transform::createLinearTransform(0.5);

/// What a packet holds, as a page reads it.
struct Unpacked {
    nlohmann::json told;
    std::vector<float> driver, color;
    std::vector<std::uint32_t> ids, counts;
    std::vector<std::uint16_t> places[3], times, own;

    explicit Unpacked(const std::string& bytes)
    {
        std::uint32_t length = 0;
        std::memcpy(&length, bytes.data(), 4);
        told = nlohmann::json::parse(bytes.substr(4, length));
        EXPECT_EQ(length % 4, 0U);
        std::size_t at = 4 + length;
        const auto take = [&](auto& values, const char* count) {
            values.resize(told.at(count).get<std::size_t>());
            const std::size_t size = values.size() * sizeof(values[0]);
            ASSERT_LE(at + size, bytes.size());
            std::copy_n(bytes.data() + at, size, reinterpret_cast<char*>(values.data()));
            at += size;
        };
        take(driver, "points");
        if (told.at("hasColor")) take(color, "points");
        take(ids, "lines");
        take(counts, "lines");
        for (auto& column : places)
            take(column, "points");
        take(times, "points");
        take(own, "lines");
        EXPECT_EQ(at, bytes.size());
    }
    [[nodiscard]] double place(int axis, std::size_t point) const
    {
        const double low = told.at("low").at(axis), high = told.at("high").at(axis);
        return low + (high - low) * places[axis][point] / 65535;
    }
};

/// Lines of random points; their ids are multiples of 3.
Lines randomLines(int count)
{
    Lines lines;
    std::mt19937 random(1);
    std::uniform_real_distribution<float> place(-20, 50);
    for (int line = 0; line < count; ++line) {
        const auto begin = std::uint32_t(lines.pointCount());
        const int points = 2 + line % 5;
        for (int i = 0; i < points; ++i) {
            lines.positions.emplace_back(place(random), place(random), place(random) / 10);
            lines.radii.push_back(0.25f);
            lines.opacities.push_back(0.8f * float(i) / float(points - 1));
            lines.ages.push_back(float(points - 1 - i));
        }
        lines.lines.push_back({3 * line, begin, std::uint32_t(lines.pointCount())});
    }
    return lines;
}

Tubes tubesOf(const Lines& lines, Tubes::Values values)
{
    return {lines, std::move(values), *kHalf, {1, 1, 2}, [](const openvdb::Coord&) { return true; }};
}

const Corners kSmall{}; // a box around the origin

TEST(LinePacket, HasEveryPointInPlace)
{
    const Lines lines = randomLines(200);
    std::vector<float> driver(lines.pointCount()), color(lines.pointCount(), 2);
    for (std::size_t i = 0; i < driver.size(); ++i)
        driver[i] = float(i);
    const Unpacked packet(linePacket(tubesOf(lines, {driver, color}), kSmall, 1'000'000));
    EXPECT_EQ(packet.told.at("part"), 1);
    EXPECT_NEAR(packet.told.at("radius").get<double>(), 0.25 * std::cbrt(2), 1e-6);
    ASSERT_EQ(packet.ids.size(), 200U);
    ASSERT_EQ(packet.driver.size(), lines.pointCount());
    std::size_t point = 0;
    for (std::size_t line = 0; line < 200; ++line) {
        EXPECT_EQ(packet.ids[line], 3 * line);
        EXPECT_NEAR(packet.own[line], 0.8 * 65535, 1);
        for (std::uint32_t i = 0; i < packet.counts[line]; ++i, ++point) {
            EXPECT_EQ(packet.driver[point], float(point));
            EXPECT_EQ(packet.color[point], 2);
            for (int axis = 0; axis < 3; ++axis) {
                const double side = packet.told["high"][axis].get<double>() - packet.told["low"][axis].get<double>();
                const double stretched = lines.positions[point][axis] * 0.5 * (axis == 2 ? 2 : 1);
                EXPECT_NEAR(packet.place(axis, point), stretched, side / 60000);
            }
            EXPECT_NEAR(packet.times[point], 65534.0 * i / (packet.counts[line] - 1), 10);
        }
    }
    EXPECT_EQ(point, lines.pointCount());
}

TEST(LinePacket, KeepsAnEvenPartOfTooManyLines)
{
    const Lines lines = randomLines(1000);
    const Tubes tubes = tubesOf(lines, {std::vector<float>(lines.pointCount(), 1), {}});
    const Unpacked packet(linePacket(tubes, kSmall, lines.pointCount() / 3));
    EXPECT_EQ(packet.told.at("part"), 4);
    EXPECT_FALSE(packet.told.at("hasColor"));
    EXPECT_EQ(packet.ids.size(), 250U);
    EXPECT_TRUE(std::ranges::all_of(packet.ids, [](std::uint32_t id) { return id % 4 == 0; }));
}

TEST(LinePacket, TimesRiseWhateverTheOpacitiesAre)
{
    Lines lines = randomLines(3);
    std::ranges::fill(lines.opacities, 1.0f);
    lines.opacities[0] = -3;
    for (const float all : {1.0f, 0.0f}) {
        const Unpacked packet(linePacket(tubesOf(lines, {std::vector<float>(lines.pointCount(), 1), {}}), kSmall, 100));
        std::size_t point = 0;
        for (const std::uint32_t count : packet.counts) {
            for (std::uint32_t i = 1; i < count; ++i)
                EXPECT_LT(packet.times[point + i - 1], packet.times[point + i]);
            point += count;
        }
        std::ranges::fill(lines.opacities, all);
    }
}

TEST(LinePacket, TakesWhatIsNoNumberFromTheNextPoint)
{
    const Lines lines = randomLines(2); // 2 and 3 points
    const Tubes tubes = tubesOf(lines, {{kNothing, 1, kNothing, 5, kNothing}, {}});
    EXPECT_EQ(Unpacked(linePacket(tubes, kSmall, 100)).driver, (std::vector<float>{1, 1, 5, 5, 5}));
    // A cone between two of them is none.
    const Unpacked without(linePacket(tubesOf(lines, {{kNothing, kNothing, 3, 5, 6}, {}}), kSmall, 100));
    EXPECT_EQ(without.driver, (std::vector<float>{3, 5, 6}));
    EXPECT_TRUE(Unpacked(linePacket(tubesOf({}, {}), kSmall, 100)).driver.empty());
}

TEST(LinePacket, HostilePlacesAreHarmless)
{
    Lines lines = randomLines(50);
    lines.positions[3] = {1e38f, -1e38f, 0};
    lines.positions[9] = {std::numeric_limits<float>::max(), 0, 0};
    const Unpacked packet(linePacket(tubesOf(lines, {std::vector<float>(lines.pointCount(), 1), {}}), kSmall, 1000));
    EXPECT_EQ(packet.driver.size(), lines.pointCount());
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_TRUE(packet.told["low"][axis].is_number() && packet.told["high"][axis].is_number());
}

/// A viewer of a file of lines.
class ViewedLines : public testing::Test {
  protected:
    std::string packetOf(const openvdb::GridBase::Ptr& grid)
    {
        openvdb::MetaMap metadata;
        metadata.insertMeta(kTextureKey, openvdb::StringMetadata(kLineGrid));
        writeVdb(mFolder / "s.1.vdb", {lineGrid(randomLines(20), *kHalf)}, metadata);
        Viewer viewer(Start{{.pattern = (mFolder / "s.1.vdb").string()}, {}, nlohmann::json::object(), {}}, 1e9);
        EXPECT_TRUE(viewer.hasLines());
        writeVdb(mFolder / "s.1.vdb", {grid}, metadata);
        return viewer.lines({{"by", "age"}}, 1);
    }

    TemporaryFolder mFolder;
};

TEST_F(ViewedLines, AreRefusedIfTheyAreNoNumbers)
{
    EXPECT_EQ(Unpacked(packetOf(lineGrid(randomLines(30), *kHalf))).ids.size(), 30U);
    for (const char* attribute : {"pscale", "age"}) {
        const openvdb::GridBase::Ptr grid = lineGrid(randomLines(30), *kHalf);
        auto& tree = openvdb::gridPtrCast<openvdb::points::PointDataGrid>(grid)->tree();
        for (auto leaf = tree.beginLeaf(); leaf; ++leaf) {
            const auto values = openvdb::points::AttributeWriteHandle<float>::create(leaf->attributeArray(attribute));
            values->set(0, kNothing);
        }
        EXPECT_THROW((void)packetOf(grid), InputError) << attribute;
    }
}

} // namespace
} // namespace vdblic::view
