#include "vdblic/methods/streaks/streak_shape.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/extent.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdblic {
namespace {

std::string numbersText(const std::array<float, 3>& numbers)
{
    if (numbers[0] == numbers[1] && numbers[1] == numbers[2]) return fmt::format("{}", numbers[0]);
    return fmt::format("{} {} {}", numbers[0], numbers[1], numbers[2]);
}

/// A number rounded to two digits, easy to type.
float rounded(double number)
{
    const double step = std::pow(10.0, std::floor(std::log10(number)) - 1);
    return float(std::round(number / step) * step);
}

std::array<float, 3> chosenSpacing(double voxels, const openvdb::CoordBBox& box)
{
    constexpr double kInVolume = 30e3, kInLayer = 6e3; // cells of one spacing
    constexpr double kLeast = 0.25, kThin = 4;
    const auto [x, y, z] = extentOf(box);
    const auto least = double(std::min({x, y, z}));
    const bool isLayer = least <= kThin && least * 8 <= double(std::max({x, y, z}));
    const double spacing = isLayer ? std::sqrt(voxels / least / kInLayer) : std::cbrt(voxels / kInVolume);
    const float chosen = rounded(std::max(spacing, kLeast));
    return {chosen, chosen, chosen};
}

void checkSpacing(const std::array<float, 3>& spacing, const openvdb::CoordBBox& box)
{
    const std::array<std::int64_t, 3> extent = extentOf(box);
    const auto isLarger = [&](std::size_t axis) { return spacing[axis] > float(extent[axis]); };
    if (!isLarger(0) || !isLarger(1) || !isLarger(2)) return;
    throw ParameterError(fmt::format("`spacing` {} is larger than the velocity's {} x {} x {} voxels: give a smaller "
                                     "one",
                                     numbersText(spacing), extent[0], extent[1], extent[2]));
}

} // namespace

float StreakShape::radius(int axis) const
{
    constexpr float kLeast = 1; // below it, streaks between voxels are dimmer than on them
    const auto at = std::size_t(axis);
    return std::max(0.5f * kThickness * spacing[at] * float(refinement.factors[at]), kLeast);
}

float StreakShape::reach() const
{
    float most = 0;
    for (int axis = 0; axis < 3; ++axis)
        most = std::max(most, kRim * radius(axis) / float(refinement.factors[std::size_t(axis)]));
    return most;
}

std::string StreakShape::text() const
{
    const auto& [x, y, z] = refinement.factors;
    return fmt::format("spacing {}, tail {}, refine {}", numbersText(spacing), tail,
                       numbersText({float(x), float(y), float(z)}));
}

StreakShape streakShape(const StreakParams& params, const Refinement& refinement, const Domain& domain,
                        double displacement)
{
    openvdb::CoordBBox box;
    (void)domain.topology().evalActiveVoxelBoundingBox(box);
    return streakShape(params, refinement, domain.voxelCount(), box, displacement);
}

StreakShape streakShape(const StreakParams& params, const Refinement& refinement, std::size_t voxels,
                        const openvdb::CoordBBox& box, double displacement)
{
    StreakShape shape{{2, 2, 2}, 3, refinement};
    if (params.spacing) {
        shape.spacing = *params.spacing;
        if (voxels > 0) checkSpacing(shape.spacing, box);
    } else if (voxels > 0) {
        shape.spacing = chosenSpacing(double(voxels), box);
    }
    const float mean = std::cbrt(shape.spacing[0] * shape.spacing[1] * shape.spacing[2]);
    if (params.tail) {
        shape.tail = *params.tail;
    } else if (displacement > 0) {
        constexpr double kSpacings = 6, kMostFrames = 24;
        shape.tail = rounded(std::min(kSpacings * double(mean) / displacement, kMostFrames));
    }
    if (!refinement.isGiven) {
        constexpr float kVoxels = 16;         // per spacing: a thickness of 2.5 texture voxels
        constexpr double kMostVoxels = 2.5e8; // of the texture, empty ones included
        const double most = std::cbrt(kMostVoxels / double(std::max<std::size_t>(voxels, 1)));
        for (std::size_t axis = 0; axis < 3; ++axis)
            shape.refinement.factors[axis] = std::clamp(
                int(std::min(std::round(double(kVoxels / shape.spacing[axis])), most)), 1, Refinement::kMost);
    }
    return shape;
}

} // namespace vdblic
