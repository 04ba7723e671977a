#include "vdblic/cast/earth_map.h"

#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace vdblic {
namespace {

/// A place on a sphere [degrees].
glm::dvec3 placeAt(double longitude, double latitude, double radius = 6.371)
{
    const double east = glm::radians(longitude), north = glm::radians(latitude);
    return radius * glm::dvec3(std::cos(north) * std::cos(east), std::cos(north) * std::sin(east), std::sin(north));
}

constexpr double kPixel = 0.001;

/// Half a white light at a place away from all lines is the sea's or the land's.
bool isLand(const EarthMap& map, double longitude, double latitude)
{
    const glm::vec3 color = map.colored(glm::vec3(0.5F), placeAt(longitude, latitude), kPixel);
    EXPECT_TRUE(color == glm::vec3(0.5F) || color.b < 0.2F) << longitude << ' ' << latitude;
    return color == glm::vec3(0.5F);
}

TEST(EarthMap, TellsLandFromSea)
{
    const EarthMap map;
    const glm::dvec2 land[] = {{13.4, 52.5},  {20, 22},       {134, -25}, {-56, -12},  {-41, 72}, {101, 62},
                               {179.5, 67.5}, {-179.5, 67.5}, {50, -88},  {-130, -86}, {-100, 41}};
    const glm::dvec2 sea[] = {{-152, 5},    {-40, 35},    {18, 35},    {80, -40}, {10, 88},
                              {50.6, 41.9}, {-179.5, 10}, {179.5, 10}, {-86, 59}, {40, -62}};
    for (const glm::dvec2& place : land)
        EXPECT_TRUE(isLand(map, place.x, place.y)) << place.x << ' ' << place.y;
    for (const glm::dvec2& place : sea)
        EXPECT_FALSE(isLand(map, place.x, place.y)) << place.x << ' ' << place.y;
}

/// The land of Natural Earth covers 29 % of the Earth.
TEST(EarthMap, HasTheEarthsShareOfLand)
{
    const EarthMap map;
    double land = 0, all = 0;
    for (double latitude = -89.3; latitude < 90; latitude += 1.7) {
        for (double longitude = -179.2; longitude < 180; longitude += 1.7) {
            const double weight = std::cos(glm::radians(latitude));
            const glm::vec3 color = map.colored(glm::vec3(1), placeAt(longitude, latitude), 1e-9);
            land += weight * double(color.r > 0.9F);
            all += weight;
        }
    }
    EXPECT_NEAR(land / all, 0.29, 0.01);
}

TEST(EarthMap, DrawsLinesEvery15Degrees)
{
    const EarthMap map;
    const auto light = [&](double longitude, double latitude, double pixel = kPixel) {
        return map.colored(glm::vec3(1), placeAt(longitude, latitude), pixel).r;
    };
    const float sea = light(-152, 8);
    for (const double longitude : {-165.0, -150.0, -135.0})
        EXPECT_GT(light(longitude, 8), sea + 0.3F) << longitude;
    for (const double latitude : {-15.0, 0.0, 15.0})
        EXPECT_GT(light(-152, latitude), sea + 0.3F) << latitude;
    EXPECT_EQ(light(-151, 8), sea);
    EXPECT_GT(light(-151, 8, 0.2), sea);       // pixels wider than the distance of 110 km from the line
    EXPECT_EQ(light(-150.5, 82, kPixel), sea); // fewer meridians by the pole
    EXPECT_GT(light(-180, 82), sea + 0.3F);
}

TEST(EarthMap, DependsOnDirectionAlone)
{
    const EarthMap map;
    EXPECT_EQ(map.colored(glm::vec3(0.5F), placeAt(18, 35, 1), kPixel),
              map.colored(glm::vec3(0.5F), placeAt(18, 35, 9), kPixel));
    EXPECT_EQ(map.colored(glm::vec3(0.5F), glm::dvec3(0), kPixel), glm::vec3(0.5F)); // has no direction
}

} // namespace
} // namespace vdblic
