#include "cast/test_scene.h"
#include "vdblic/cast/ray_caster.h"
#include "vdblic/cast/ray_setup.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3d;

/// The definition, sample by sample: no bricks, no leaves, no lanes.
glm::vec4 referencePixel(const openvdb::FloatGrid& texture, const Look& look, const Camera& camera, int x, int y,
                         double step, const Vec3d& low, const Vec3d& high)
{
    const Ray ray = camera.ray({x + 0.5, y + 0.5});
    const Vec3d origin(ray.origin.x, ray.origin.y, ray.origin.z); // index space is world space here
    const Vec3d direction(ray.direction.x, ray.direction.y, ray.direction.z);
    double enter = 0, leave = 1e30;
    int face = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double a = (low[axis] - origin[axis]) / direction[axis],
                     b = (high[axis] - origin[axis]) / direction[axis];
        if (std::min(a, b) > enter) {
            enter = std::min(a, b);
            face = axis;
        }
        leave = std::min(leave, std::max(a, b));
    }
    const auto& tree = texture.tree();
    // Values go on past the rim along straight lines: neighbours that share a face, else an edge, else a corner,
    // decide; then once more.
    bool isStraight = true; // for the texture; the scalar is the mean of its neighbours
    const std::function<std::optional<double>(const Coord&, int)> known = [&](const Coord& c, int passes) {
        if (tree.isValueOn(c)) return std::optional(double(tree.getValue(c)));
        if (passes == 0) return std::optional<double>();
        if (const auto before = known(c, passes - 1)) return before;
        for (int distance = 1; distance <= 3; ++distance) {
            double sum = 0, count = 0;
            for (auto n = CoordBBox(c.offsetBy(-1), c.offsetBy(1)).begin(); n; ++n) {
                const Coord d = *n - c;
                if (std::abs(d[0]) + std::abs(d[1]) + std::abs(d[2]) != distance) continue;
                const std::optional<double> neighbour = known(*n, passes - 1);
                if (!neighbour) continue;
                const std::optional<double> behind = isStraight ? known(*n + d, passes - 1) : std::optional<double>();
                sum += behind ? 2 * *neighbour - *behind : *neighbour;
                count += 1;
            }
            if (count > 0) return std::optional(sum / count);
        }
        return std::optional<double>();
    };
    const auto value = [&](const Coord& c) { return known(c, 2).value_or(0); };
    const auto driver = [&](const Coord& c) {
        isStraight = false;
        const double result = value(c);
        isStraight = true;
        return result;
    };
    const auto gradient = [&](const Coord& c) {
        Vec3d g;
        for (int axis = 0; axis < 3; ++axis) {
            Coord before = c, after = c;
            --before[axis];
            ++after[axis];
            g[axis] = (value(after) - value(before)) / 2;
        }
        return g;
    };
    const auto interpolated = [&](const Vec3d& p, const auto& of) {
        auto sum = of(Coord(0)) * 0.0;
        for (int corner = 0; corner < 8; ++corner) {
            const Coord c = Coord::floor(p).offsetBy(corner >> 2, corner >> 1 & 1, corner & 1);
            double weight = 1;
            for (int axis = 0; axis < 3; ++axis)
                weight *= 1 - std::abs(p[axis] - c[axis]);
            sum += of(c) * weight;
        }
        return sum;
    };
    const auto stretchedAt = [&](const Vec3d& p) {
        return double(look.texture.stretched(broadcast8(float(interpolated(p, value))))[0]);
    };
    const Shading& s = look.shading;
    const auto highlight = [&](double cosine) {
        const double c = std::max(cosine, 0.0);
        return double(s.specular) * c / (double(s.shininess) * (1 - c) + c);
    };
    const double faceCosine = std::abs(direction[face]);
    const double faceLit = double(s.ambient) + double(s.diffuse) * faceCosine;
    const double faceWhite = highlight(2 * faceCosine * faceCosine - 1);

    glm::dvec3 color(0);
    double transmittance = 1;
    const double start = double(sampleShift(x, y)) - enter / step, span = (leave - enter) / step;
    const double shift = start - std::floor(start);
    const int count = std::max(int(std::ceil(span - shift)), 0) + 1;
    const auto middleOf = [&](int n) { return (std::max(n - 1 + shift, 0.0) + std::min(n + shift, span)) / 2; };
    double before = 0;
    for (int n = 0; n < count; ++n) {
        // A sample ends what lies between it and the one before; the last one stands for the rest, too.
        const double previous = n > 0 ? middleOf(n - 1) : 0, here = middleOf(n), end = n + 1 < count ? here : span;
        const double distance = (previous + here) / 2 * step;
        const Vec3d sample = origin + direction * (enter + here * step), p = origin + direction * (enter + distance);
        const double after = stretchedAt(sample);
        if (n == 0) before = after;
        const double from = std::exchange(before, after);
        if (!tree.isValueOn(Coord::floor(sample + Vec3d(0.5)))) continue;
        double density = 0; // the mean while the texture changes evenly
        constexpr int kParts = 256;
        for (int part = 0; part < kParts; ++part) {
            const double ramp = from + (after - from) * (part + 0.5) / kParts;
            density += double(look.texture.density(broadcast8(float(ramp)))[0]) / kParts;
        }
        const double met = interpolated(p, driver);
        const Vec3d normal = interpolated(p, gradient);
        const auto& entry = look.transfer.table()[look.transfer.entries(broadcast8(float(met)))[0]];
        const Float8 stretched = broadcast8(float((from + after) / 2));
        const double alpha = 1 - std::exp(-double(entry.extinction) * density * (end - previous) * step);
        const double length = normal.length();
        const double facing = length > 0 ? std::abs(normal.dot(direction)) / length : 0;
        const double steep = length / double(look.texture.high - look.texture.low);
        const double surface = steep / (steep + double(s.leastGradient));
        const double near = std::clamp(1 - distance, 0.0, 1.0);
        double lit = 1 - surface + surface * (double(s.ambient) + double(s.diffuse) * facing);
        double white = surface * highlight(2 * facing * facing - 1);
        lit += (faceLit - lit) * near;
        white += (faceWhite - white) * near;
        const double tint = double(look.texture.brightness(stretched)[0]) * lit;
        color += transmittance * alpha * (glm::dvec3(entry.red, entry.green, entry.blue) * tint + white);
        transmittance *= 1 - alpha;
    }
    return {color, 1 - transmittance};
}

TEST(RayDefinition, IsWhatTheRayCasterComputes)
{
    // Smooth, so that a sample at an entry's edge is no more than an entry off; a hole inside, rims off the leaves'
    // faces.
    const auto grid = boxGrid("density", {{1, 2, 3}, {21, 14, 17}}, [](const Coord& c) {
        return float(0.5 + 0.45 * std::sin(c.x() * 0.7) * std::cos(c.y() * 0.5 + c.z() * 0.4));
    });
    for (auto i = CoordBBox({9, 6, 7}, {11, 9, 9}).begin(); i; ++i)
        grid->tree().setValueOff(*i);
    const TextureVolume volume(*grid, *grid);
    Look look = fullLook(); // of which nothing is hidden
    look.transfer = TransferFunction({.opacity = {{0, 0.02}, {0.6, 0.2}, {1, 0.7}}, .range = std::array{0.0, 1.0}});
    const Camera camera = cameraAlong(volume, glm::normalize(glm::dvec3(0.7, 0.5, -0.4)), 50, 25, {24, 18});
    const Image image = castRays(volume, look, camera, {.leastTransmittance = 0});
    for (int y = 0; y < image.size.y; ++y) {
        for (int x = 0; x < image.size.x; ++x) {
            const glm::vec4 expected =
                referencePixel(*grid, look, camera, x, y, 1, Vec3d(0.5, 1.5, 2.5), Vec3d(21.5, 14.5, 17.5));
            const glm::vec4 error = glm::abs(image.at(x, y) - expected);
            EXPECT_LT(std::max({error.r, error.g, error.b, error.a}), 2e-3f) << x << " " << y;
        }
    }
}

} // namespace
} // namespace vdblic
