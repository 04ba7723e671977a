#pragma once

#include "cli/tool.h"
#include "vdblic/field/velocity_frame.h"

#include <optional>
#include <string>

namespace vdblic::cli {

/// The options that say how a velocity and its frame spacing are understood.
///
/// Construct before parsing. This and the parameters must outlive the parsing.
class VelocityOptions {
  public:
    /// @param frameSpacing seconds between the frames on disk
    VelocityOptions(Tool& tool, VelocityParams& velocity, std::optional<double>& frameSpacing);

    /// Set what needs more than parsing in the parameters. @throws ParameterError
    void apply() const;

  private:
    VelocityParams& mVelocity;
    std::optional<double>& mFrameSpacing;
    std::string mUnit;
    std::optional<double> mFramesPerSecond;
};

} // namespace vdblic::cli
