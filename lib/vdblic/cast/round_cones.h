#pragma once

#include "vdblic/cast/lanes.h"
#include "vdblic/field/vector.h"

namespace vdblic {

VDBLIC_INLINE Float8 dot(const Vector8& a, const Vector8& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// The hulls of two spheres, one a lane.
struct RoundCones {
    Vector8 a, axis;       // centres of the first spheres, and the vectors to the second ones'
    Float8 radius, shrink; // of the first spheres; by how much the second ones are smaller
    Float8 square;         // of the axes' lengths

    VDBLIC_INLINE RoundCones(const Vector8& first, Float8 firstRadius, const Vector8& second, Float8 secondRadius)
        : a(first), axis(second - first), radius(firstRadius), shrink(firstRadius - secondRadius),
          square(squaredLength(axis))
    {
    }

    /// Whether points lie well inside.
    [[nodiscard]] VDBLIC_INLINE Int8 hold(const Vector8& points) const
    {
        constexpr float kWell = 0.999f;
        const Vector8 from = points - a;
        const Float8 along = square > 0 ? clamped(dot(from, axis) / square) : Float8{};
        const Vector8 aside = from - axis * along;
        const Float8 reach = kWell * (radius - shrink * along);
        return squaredLength(aside) < reach * reach;
    }
};

/// Where lines enter something, one a lane.
struct Entries {
    Int8 isThere;
    Float8 distance; ///< from the lines' origins
    Float8 share;    ///< position between the first sphere, 0, and the second, 1
    Vector8 normal;  ///< outward, of length 1
};

VDBLIC_INLINE Entries select(Int8 mask, const Entries& a, const Entries& b)
{
    return {mask ? a.isThere : b.isThere, mask ? a.distance : b.distance, mask ? a.share : b.share,
            select(mask, a.normal, b.normal)};
}

/// Where lines enter spheres. @param from of the spheres' centres to the lines' origins
VDBLIC_INLINE Entries enterSpheres(const Vector8& from, const Vector8& direction, Float8 radius, float share)
{
    const Float8 middle = -dot(from, direction);
    const Vector8 aside = from + direction * middle;
    const Float8 rest = radius * radius - squaredLength(aside);
    const Float8 distance = middle - squareRoots(rest);
    const Vector8 outward = from + direction * distance;
    return {rest > 0, distance, broadcast8(share), {outward.x / radius, outward.y / radius, outward.z / radius}};
}

/// Where lines enter round cones: their mantles, or one of their spheres. The mantle touches the spheres and holds
/// them, so a line that misses it misses all (the quadratic equation as Quilez has it, "Rounded cone", 2018).
/// @param mask      of the lanes to look at; others have no entry
/// @param from      of the first spheres' centres to the lines' origins
/// @param direction of length 1
VDBLIC_INLINE Entries enter(Int8 mask, const RoundCones& cones, const Vector8& from, const Vector8& direction)
{
    const Float8 square = cones.square - cones.shrink * cones.shrink;
    const Float8 along = dot(direction, cones.axis), start = dot(from, cones.axis);
    const Float8 a = square - along * along;
    const Float8 b = square * dot(from, direction) - start * along + along * cones.shrink * cones.radius;
    const Float8 c = square * squaredLength(from) - start * start + 2 * start * cones.shrink * cones.radius -
                     cones.square * cones.radius * cones.radius;
    const Float8 discriminant = b * b - a * c;
    const Int8 hasMantle = square > 0, meets = mask & (~hasMantle | (discriminant >= 0));
    if (!anyOf(meets)) return {Int8{}, Float8{}, Float8{}, Vector8{}};
    constexpr float kParallel = 1e-6f;
    const Int8 isAcross = (a > kParallel * square) | (-a > kParallel * square);
    const Float8 distance = (-b - squareRoots(discriminant)) / a;
    const Float8 height = start - cones.radius * cones.shrink + distance * along;
    const Vector8 outward = (from + direction * distance) * square - cones.axis * height;
    const Entries mantle{hasMantle & meets & isAcross & (height >= 0) & (height <= square), distance, height / square,
                         outward * (1 / squareRoots(squaredLength(outward)))};
    const Int8 isPast = meets & ~mantle.isThere;
    if (!anyOf(isPast)) return mantle;
    const Entries first = enterSpheres(from, direction, cones.radius, 0);
    const Entries second = enterSpheres(from - cones.axis, direction, cones.radius - cones.shrink, 1);
    const Int8 isSecond = second.isThere & ~(first.isThere & (first.distance <= second.distance));
    return select(isPast, select(isSecond, second, first), mantle);
}

} // namespace vdblic
