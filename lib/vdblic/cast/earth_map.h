#pragma once

#include <glm/vec3.hpp>

#include <cstdint>
#include <vector>

namespace vdblic {

/// Continents and a graticule on the surface of the Earth, whose centre is the origin: z leads to the north pole, x to
/// 0° E. Land is that of Natural Earth 1:110m (public domain). Immutable; any number of threads may read.
class EarthMap {
  public:
    EarthMap(); ///< draws the land on an image of 8 megabytes

    /// The colour of a place: land has the given one, the sea is darker and bluer, lines every 15 degrees are lighter.
    /// @param color linear light  @param place on the surface  @param pixel size of a picture's pixel there
    [[nodiscard]] glm::vec3 colored(const glm::vec3& color, const glm::dvec3& place, double pixel) const;

  private:
    [[nodiscard]] double land(double longitude, double latitude) const;

    std::vector<std::uint8_t> mLand; ///< share of land, 0 to 255; rows from the south, columns from 180° W eastward
};

} // namespace vdblic
