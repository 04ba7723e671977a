#include "cast/test_scene.h"
#include "vdblic/cast/ray_caster.h"
#include "vdblic/cast/ray_setup.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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
    const auto gradient = [&](const Coord& c) {
        Vec3d g(0);
        if (!tree.isValueOn(c)) return g;
        for (int axis = 0; axis < 3; ++axis) {
            Coord before = c, after = c;
            if (Coord next = c; (++next[axis], tree.isValueOn(next))) after = next;
            if (Coord next = c; (--next[axis], tree.isValueOn(next))) before = next;
            const auto span = float(after[axis] - before[axis]);
            if (span > 0) g[axis] = (tree.getValue(after) - tree.getValue(before)) / span;
        }
        return g;
    };
    const auto value = [&](const Coord& c) {
        for (int distance = 0; distance <= 3; ++distance) { // 1: neighbours that share a face; 2: an edge; 3: a corner
            double sum = 0, count = 0;
            for (auto n = CoordBBox(c.offsetBy(-1), c.offsetBy(1)).begin(); n; ++n) {
                const Coord d = *n - c;
                if (std::abs(d[0]) + std::abs(d[1]) + std::abs(d[2]) != distance || !tree.isValueOn(*n)) continue;
                sum += double(tree.getValue(*n));
                count += 1;
            }
            if (count > 0) return sum / count;
        }
        return 0.0;
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
    for (int n = 0; n == 0 || n - 1 + shift < span; ++n) {
        const double begin = std::max(n - 1 + shift, 0.0), end = std::min(n + shift, span);
        const double distance = (begin + end) / 2 * step;
        const Vec3d p = origin + direction * (enter + distance);
        if (!tree.isValueOn(Coord::floor(p + Vec3d(0.5)))) continue;
        double met = 0;
        Vec3d normal(0);
        for (int corner = 0; corner < 8; ++corner) {
            const Coord c = Coord::floor(p).offsetBy(corner >> 2, corner >> 1 & 1, corner & 1);
            double weight = 1;
            for (int axis = 0; axis < 3; ++axis)
                weight *= 1 - std::abs(p[axis] - c[axis]);
            met += weight * value(c);
            normal += gradient(c) * weight;
        }
        const auto& entry = look.transfer.table()[look.transfer.entries(broadcast8(float(met)))[0]];
        const Float8 stretched = look.texture.stretched(broadcast8(float(met)));
        const double alpha =
            1 - std::exp(-double(entry.extinction) * double(look.texture.density(stretched)[0]) * (end - begin) * step);
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
    const Look look = fullLook();
    const Camera camera = cameraAlong(volume, glm::normalize(glm::dvec3(0.7, 0.5, -0.4)), 50, 25, {24, 18});
    const Image image = castRays(volume, look, camera, {.leastTransmittance = 0});
    for (int y = 0; y < image.size.y; ++y) {
        for (int x = 0; x < image.size.x; ++x) {
            const glm::vec4 expected =
                referencePixel(*grid, look, camera, x, y, 0.5, Vec3d(0.5, 1.5, 2.5), Vec3d(21.5, 14.5, 17.5));
            const glm::vec4 error = glm::abs(image.at(x, y) - expected);
            EXPECT_LT(std::max({error.r, error.g, error.b, error.a}), 2e-3f) << x << " " << y;
        }
    }
}

} // namespace
} // namespace vdblic
