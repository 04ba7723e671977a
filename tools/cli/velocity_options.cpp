#include "cli/velocity_options.h"

namespace vdblic::cli {

VelocityOptions::VelocityOptions(Tool& tool, VelocityParams& velocity, std::optional<double>& frameSpacing)
    : mVelocity(velocity), mFrameSpacing(frameSpacing)
{
    tool.option("--velocity", velocity.grid, "Name of the velocity grid, or of three scalar grids.");
    tool.option("--velocity-unit", mUnit,
                "world/s, world/frame, voxel/s or voxel/frame; world/s unless the file is known.");
    tool.option("--velocity-scale", velocity.scale, "Factor on the velocities.");
    auto* dt = tool.option("--dt", frameSpacing,
                           "Seconds between the frames on disk; from the files' metadata by default, else 1/24.");
    tool.option("--fps", mFramesPerSecond, "Frames per second, instead of --dt.")->excludes(dt);
}

void VelocityOptions::apply() const
{
    if (!mUnit.empty()) mVelocity.unit = parseVelocityUnit(mUnit);
    if (mFramesPerSecond) mFrameSpacing = 1 / *mFramesPerSecond;
}

} // namespace vdblic::cli
