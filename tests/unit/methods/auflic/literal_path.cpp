#include "methods/auflic/literal_path.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vdblic::test {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

Coord cellAround(const Vec3f& position)
{
    return {int(std::floor(position[0])), int(std::floor(position[1])), int(std::floor(position[2]))};
}

float lengthOf(const Vec3f& v)
{
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/// One integration step: a Hermite curve between two positions with their velocities.
struct Curve {
    Vec3f start, end, startSlope, endSlope;
    float time, duration;
};

/// The part of a step in which a velocity leads no farther than a leaf.
float longestDuration(const Vec3f& slope)
{
    constexpr float kLeaf = 8;
    return kLeaf / std::max(lengthOf(slope), kLeaf);
}

/// The path over the step, up to the first curve that ends outside the domain.
std::vector<Curve> integrate(const LiteralField& field, float tolerance, const Vec3f& position, const Vec3f& slope)
{
    constexpr float kShortest = 1.0f / 4096;
    const auto velocity = [&](const Vec3f& at, float time, const Vec3f& before) {
        return field.at(at, time).value_or(before);
    };
    std::vector<Curve> path;
    Vec3f x = position, k1 = slope;
    float time = 0, h = longestDuration(slope);
    for (bool isDone = false; !isDone;) {
        const Vec3f k2 = velocity(x + k1 * (h * 0.5f), time + h * 0.5f, k1);
        const Vec3f k3 = velocity(x + k2 * (h * 0.5f), time + h * 0.5f, k2);
        const Vec3f k4 = velocity(x + k3 * h, time + h, k3);
        const Vec3f end = x + (k1 + (k2 + k3) * 2.0f + k4) * (h * (1.0f / 6));
        const Vec3f k5 = velocity(end, time + h, k4);

        // Squares throughout: the error's fourth root is the eighth of its square.
        const Vec3f difference = k4 - k5;
        const float error2 = difference.dot(difference) * (h * h * (1.0f / 36)), allowed2 = tolerance * tolerance;
        const float ratio = std::sqrt(std::sqrt(std::sqrt(allowed2 / std::max(error2, 1e-12f * allowed2))));
        const float suitable = h * std::clamp(0.9f * ratio, 0.2f, 4.0f);
        if (error2 > allowed2 && h > kShortest) {
            h = std::max(suitable, kShortest);
            continue;
        }
        path.push_back({x, end, k1, k5, time, h});
        isDone = !(h < 1 - time) || !field.covers(end);
        time += h;
        h = std::min(std::max(std::min(suitable, longestDuration(k5)), kShortest), 1 - time);
        x = end;
        k1 = k5;
    }
    return path;
}

/// The corners of a tetrahedron, without their parts along a chord: samples are moved by them in turn.
Vec3f offsetAcross(const Vec3f& chord, int number)
{
    constexpr float kDistance = 0.2f; // voxels
    static const std::array<Vec3f, 4> corners = {Vec3f(1, 1, 1), Vec3f(-1, -1, 1), Vec3f(-1, 1, -1), Vec3f(1, -1, -1)};
    const float length = lengthOf(chord);
    const Vec3f direction = chord * (1 / (length > 1e-6f ? length : 1)), &corner = corners[std::size_t(number % 4)];
    return (corner - direction * direction.dot(corner)) * kDistance;
}

/// Sample a curve at the middles of equally long pieces. @param visit called with the voxel and the time
template<typename Visit>
void sample(const Curve& curve, float spacing, const Visit& visit)
{
    constexpr float kLeastSpeed = 1e-3f, kMostPieces = 1024;
    const Vec3f chord = curve.end - curve.start, m0 = curve.startSlope * curve.duration,
                m1 = curve.endSlope * curve.duration;
    const Vec3f square = chord * 3.0f - m0 * 2.0f - m1, cube = m0 + m1 - chord * 2.0f;
    const float first = lengthOf(m0) + kLeastSpeed, last = lengthOf(m1) + kLeastSpeed; // speeds
    const float arc = (first + last) * 0.5f;
    const int pieces = int(std::ceil(std::min(std::max(arc, lengthOf(chord)) * (1 / spacing), kMostPieces)));
    for (int i = 0; i < pieces; ++i) {
        // The speed changes linearly: the arc length is first · u + (last − first) · u² / 2.
        const float s = arc / float(pieces) * (float(i) + 0.5f);
        const float u = s * 2.0f / (std::sqrt(first * first + (last - first) * 2.0f * s) + first);
        const Vec3f offset = offsetAcross(chord, i);
        Coord voxel;
        for (int axis = 0; axis < 3; ++axis) {
            const float moved = ((u * cube[axis] + square[axis]) * u + m0[axis]) * u;
            voxel[axis] = int(std::floor(moved + (curve.start[axis] + 0.5f + offset[axis])));
        }
        visit(voxel, u * curve.duration + curve.time);
    }
}

} // namespace

Coord voxelAround(const Vec3f& position)
{
    return cellAround(position + Vec3f(0.5f));
}

std::optional<Vec3f> placeInBlocks(const openvdb::MaskTree& blocks, const Vec3f& position)
{
    const auto has = [&](const Coord& voxel) { return blocks.probeConstLeaf(voxel) != nullptr; };
    const Coord cell = cellAround(position), nearest = voxelAround(position);
    if (has(cell)) return position;
    for (const auto& axes : std::vector<std::vector<int>>{{0}, {1}, {2}, {0, 1}, {0, 2}, {1, 2}, {0, 1, 2}}) {
        Vec3f place = position;
        Coord moved = cell;
        bool areMoved = true;
        for (const int axis : axes) {
            areMoved = areMoved && nearest[axis] != cell[axis];
            moved[axis] = nearest[axis];
            place[axis] = float(nearest[axis]);
        }
        if (areMoved && has(moved)) return place;
    }
    return std::nullopt;
}

std::optional<Vec3f> LiteralField::at(const Vec3f& position, float time) const
{
    Vec3f coarse, factors;
    for (int axis = 0; axis < 3; ++axis) { // (f + ½) / N − ½
        factors[axis] = float(mStart.domain.refinement.factors[std::size_t(axis)]);
        const float scale = 1 / factors[axis];
        coarse[axis] = position[axis] * scale + (0.5f * scale - 0.5f);
    }
    const std::optional<Vec3f> place = placeInBlocks(mStart.domain.velocity->topology(), coarse);
    if (!place) return std::nullopt;
    const Coord cell = cellAround(*place);
    const Vec3f fraction = *place - Vec3f(cell.asVec3s());
    const auto ofFrame = [&](const openvdb::Vec3SGrid::ConstAccessor& values) {
        std::array<std::array<float, 4>, 8> corners{}; // three components and the weight
        for (int i = 0; i < 8; ++i) {
            Vec3f value;
            if (!values.probeValue(cell.offsetBy(i >> 2, i >> 1 & 1, i & 1), value)) continue;
            corners[std::size_t(i)] = {value[0] * factors[0], value[1] * factors[1], value[2] * factors[2], 1};
        }
        std::array<float, 4> result{};
        for (std::size_t number = 0; number < 4; ++number) {
            result[number] = trilinear(fraction, [&](int i, int j, int k) {
                return corners[std::size_t(i) * 4 + std::size_t(j) * 2 + std::size_t(k)][number];
            });
        }
        return result;
    };
    const std::array<float, 4> first = ofFrame(mAtStart), last = ofFrame(mAtEnd);
    const auto between = [&](std::size_t number) { return first[number] + (last[number] - first[number]) * time; };
    const float weight = between(3);
    if (!(weight > 0)) return std::nullopt;
    return Vec3f(between(0) / weight, between(1) / weight, between(2) / weight);
}

bool LiteralField::covers(const Vec3f& position) const
{
    return mStart.domain.texture->topology().isValueOn(voxelAround(position));
}

LiteralTrace literalTrace(const LiteralField& field, const TextureParams& params, Vec3f position, Vec3f slope)
{
    const std::vector<Curve> path = integrate(field, params.pathline.tolerance, position, slope);
    LiteralTrace trace{path.back().end, path.back().endSlope, {}, false};
    for (const Curve& curve : path) {
        sample(curve, params.pathline.sampleSpacing, [&](const Coord& voxel, float time) {
            trace.ended = trace.ended || !field.start().domain.texture->topology().isValueOn(voxel);
            if (!trace.ended) trace.samples.push_back({voxel, time < params.releaseWindow});
        });
    }
    return trace;
}

} // namespace vdblic::test
