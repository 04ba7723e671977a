#include "vdblic/film/film_cost.h"

#include "vdblic/core/memory.h"
#include "vdblic/film/film_plan.h"
#include "vdblic/methods/memory_estimate.h"
#include "vdblic/methods/streaks/streaks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdblic {

void addDenseCost(FilmPlan& plan, double pixels, bool withLines)
{
    constexpr double kBytes = 63e6, kBytesPerPixel = 158, kBytesPerVoxel = 54;
    constexpr double kSecondsPerPixel = 1.6e-6, kSecondsPerSample = 1.2e-8, kSecondsPerVoxel = 2.4e-7;
    constexpr double kFewerRays = 0.75;
    const double voxels = plan.textureVoxels;
    const double pixel = kSecondsPerPixel + kSecondsPerSample * std::cbrt(voxels);
    plan.textureBytes = std::max(plan.textureBytes, denseBytes(1.5 * voxels));
    plan.pictureBytes += kBytes + kBytesPerPixel * pixels + kBytesPerVoxel * voxels;
    plan.seconds += denseSeconds(voxels, double(plan.textures)) +
                    double(plan.pictures) * (pixels * pixel * (withLines ? kFewerRays : 1) + voxels * kSecondsPerVoxel);
}

void addStreakCost(FilmPlan& plan, const StreakCost& cost, double pixels)
{
    constexpr double kBytes = 175e6, kBytesPerPixel = 75, kBytesPerStreak = 3500;
    constexpr double kSecondsPerPixel = 5e-7, kSecondsPerPixelAndStreak = 2e-11;
    plan.textureBytes = std::max(plan.textureBytes, cost.bytes);
    if (plan.textureVoxels == 0) plan.pictureBytes += kBytes + kBytesPerPixel * pixels;
    plan.pictureBytes += kBytesPerStreak * cost.streaks;
    plan.seconds += double(plan.textures) * cost.secondsPerFrame +
                    double(plan.pictures) * pixels * (kSecondsPerPixel + kSecondsPerPixelAndStreak * cost.streaks);
}

std::string costText(const FilmPlan& plan)
{
    return fmt::format("{} of memory and {:.0f} s of processor time",
                       memoryText(std::max(plan.textureBytes, plan.pictureBytes)), std::max(plan.seconds, 1.0));
}

} // namespace vdblic
