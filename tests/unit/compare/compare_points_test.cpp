#include "vdblic/compare/compare.h"

#include <openvdb/openvdb.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/points/PointGroup.h>

#include <gtest/gtest.h>
#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdblic {
namespace {

using namespace openvdb;
using points::PointDataGrid;

struct Particle {
    Vec3f position;
    int id;
    float mass;
    std::string name;
};

std::vector<Particle> cloud()
{
    std::vector<Particle> particles;
    for (int i = 0; i < 2000; ++i) {
        const auto t = float(i);
        particles.push_back(
            {Vec3f(10 * std::sin(t), 10 * std::cos(1.7f * t), 0.01f * t), i, 0.5f * t, i % 2 == 0 ? "even" : "odd"});
    }
    return particles;
}

PointDataGrid::Ptr gridOf(const std::vector<Particle>& particles, bool withId = true)
{
    openvdb::initialize();
    std::vector<Vec3f> positions;
    std::vector<int> ids;
    std::vector<float> masses;
    std::vector<Name> names;
    for (const Particle& particle : particles) {
        positions.push_back(particle.position);
        ids.push_back(particle.id);
        masses.push_back(particle.mass);
        names.push_back(particle.name);
    }
    const auto transform = math::Transform::createLinearTransform(0.5);
    const points::PointAttributeVector<Vec3f> wrapper(positions);
    const auto index = tools::createPointIndexGrid<tools::PointIndexGrid>(wrapper, *transform);
    auto grid = points::createPointDataGrid<points::NullCodec, PointDataGrid>(*index, wrapper, *transform);
    const auto add = [&](const std::string& name, const auto& values, auto example) {
        using T = decltype(example);
        points::appendAttribute<T>(grid->tree(), name);
        const points::PointAttributeVector<T> source(values);
        points::populateAttribute(grid->tree(), index->tree(), name, source);
    };
    if (withId) add("id", ids, int());
    add("mass", masses, float());
    points::appendAttribute<Name>(grid->tree(), "name");
    points::populateAttribute(grid->tree(), index->tree(), "name", points::PointAttributeVector<Name>(names));
    return grid;
}

const AttributeDifference& find(const GridDifference& result, const std::string& name)
{
    for (const auto& attribute : result.points->attributes) {
        if (attribute.name == name) return attribute;
    }
    throw std::runtime_error("no attribute " + name);
}

TEST(ComparePoints, OrderDoesNotMatterWhereThereAreIds)
{
    auto particles = cloud();
    const auto a = gridOf(particles);
    std::reverse(particles.begin(), particles.end());
    const auto b = gridOf(particles);
    const GridDifference result = compareGrids(*a, *b);
    ASSERT_TRUE(result.points);
    EXPECT_TRUE(result.points->matchedById);
    EXPECT_EQ(result.points->matched, 2000u);
    EXPECT_EQ(result.verdict(), Verdict::kSame);
    EXPECT_EQ(find(result, "mass").values->compared, 2000u);
    EXPECT_EQ(find(result, "mass").values->peak, 999.5);
    // Without ids, reversed order within a voxel is a difference.
    EXPECT_EQ(compareGrids(*gridOf(cloud(), false), *gridOf(particles, false)).verdict(), Verdict::kDiffers);
    EXPECT_EQ(compareGrids(*gridOf(cloud(), false), *gridOf(cloud(), false)).verdict(), Verdict::kSame);
}

TEST(ComparePoints, AMovedPointIsFoundInWorldUnitsAcrossVoxels)
{
    auto particles = cloud();
    const auto a = gridOf(particles);
    particles[700].position += Vec3f(3, 0, 4);
    const auto b = gridOf(particles);
    const GridDifference result = compareGrids(*a, *b, {.fail = 1e-4});
    const ValueDifference& moved = *find(result, "P").values;
    EXPECT_EQ(moved.failing, 1u);
    EXPECT_NEAR(moved.error.max, 5, 1e-5);
    EXPECT_NEAR(moved.components[0].max, 3, 1e-5);
    EXPECT_NEAR(moved.worst->world[2], 7, 1e-5); // in A
    EXPECT_EQ(moved.worst->index[2], 14);
    EXPECT_EQ(compareGrids(*a, *b, {.fail = 5.1}).verdict(), Verdict::kSame);
    // Without ids, the moved point has no partner in its new voxel: one unmatched point on either side.
    auto without = compareGrids(*gridOf(cloud(), false), *gridOf(particles, false));
    EXPECT_EQ(without.points->onlyInA, 1u);
    EXPECT_EQ(without.points->onlyInB, 1u);
}

TEST(ComparePoints, EachAttributeIsNamed)
{
    auto particles = cloud();
    const auto a = gridOf(particles);
    particles[5].mass += 0.25f;
    particles[9].name = "nine";
    const auto b = gridOf(particles);
    points::appendAttribute<double>(b->tree(), "age");
    points::appendGroup(b->tree(), "dead");
    const GridDifference result = compareGrids(*a, *b);
    EXPECT_EQ(find(result, "mass").values->failing, 1u);
    EXPECT_EQ(find(result, "mass").values->error.max, 0.25);
    EXPECT_EQ(find(result, "mass").values->worst->a, "2.5");
    EXPECT_EQ(find(result, "name").values->failing, 1u);
    EXPECT_EQ(find(result, "name").values->first->b, "\"nine\"");
    EXPECT_EQ(find(result, "P").verdict(), Verdict::kSame);
    EXPECT_EQ(find(result, "age").typeA, "");
    EXPECT_EQ(find(result, "age").typeB, "double");
    EXPECT_EQ(find(result, "dead").verdict(), Verdict::kDiffers);
    EXPECT_EQ(result.verdict(), Verdict::kDiffers);
}

TEST(ComparePoints, GroupsAreComparedPointByPoint)
{
    const auto a = gridOf(cloud()), b = gridOf(cloud());
    points::appendGroup(a->tree(), "some");
    points::appendGroup(b->tree(), "some");
    EXPECT_EQ(compareGrids(*a, *b).verdict(), Verdict::kSame);
    points::setGroup(b->tree(), "some", true);
    EXPECT_EQ(find(compareGrids(*a, *b), "some").values->failing, 2000u);
}

TEST(ComparePoints, MissingPointsAreCounted)
{
    auto particles = cloud();
    const auto a = gridOf(particles);
    particles.resize(1900);
    const auto b = gridOf(particles);
    const GridDifference result = compareGrids(*a, *b);
    EXPECT_EQ(result.verdict(), Verdict::kDiffers);
    EXPECT_EQ(result.points->onlyInA, 100u);
    EXPECT_EQ(result.points->onlyInB, 0u);
    EXPECT_EQ(compareGrids(*a, *b, {.failPercent = 5}).verdict(), Verdict::kSame);
    EXPECT_EQ(compareGrids(*a, *b, {.failPercent = 4.9}).verdict(), Verdict::kDiffers);
    EXPECT_EQ(compareGrids(*a, *PointDataGrid::create()).points->onlyInA, 2000u);
}

} // namespace
} // namespace vdblic
