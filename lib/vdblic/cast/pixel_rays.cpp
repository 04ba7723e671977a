#include "vdblic/cast/pixel_rays.h"

#include "vdblic/cast/blue_noise.h"

#include <glm/common.hpp>

#include <cmath>
#include <cstdlib>
#include <numbers>

namespace vdblic {
namespace {

/// The digits of a number mirrored at the point (van der Corput's sequence).
double radicalInverse(int number, int base)
{
    double result = 0, digit = 1;
    for (; number > 0; number /= base)
        result += number % base * (digit /= base);
    return result;
}

} // namespace

glm::dvec2 lensPoint(int x, int y, int ray)
{
    // Far from each other on the tile of blue noise, so that the two coordinates are independent.
    constexpr int kAcross = 11, kDown = 19;
    const glm::dvec2 noise(blueNoise().rank(x, y), blueNoise().rank(x + kAcross, y + kDown));
    const glm::dvec2 sequence(radicalInverse(ray, 3), radicalInverse(ray, 5));
    const glm::dvec2 square = glm::fract(sequence + (noise + 0.5) / double(BlueNoise::kCount)) * 2.0 - 1.0;
    if (square.x == 0 && square.y == 0) return square;
    const bool isWide = std::abs(square.x) > std::abs(square.y);
    const double radius = isWide ? square.x : square.y;
    const double angle = isWide ? std::numbers::pi / 4 * square.y / square.x
                                : std::numbers::pi / 2 - std::numbers::pi / 4 * square.x / square.y;
    return radius * glm::dvec2(std::cos(angle), std::sin(angle));
}

} // namespace vdblic
