#pragma once

#include "cli/tool.h"
#include "vdblic/render/look_preset.h"
#include "vdblic/render/render_sequence.h"

#include <optional>

namespace vdblic::cli {

/// The options of how a picture looks and what is cut away, on top of a look with a name.
///
/// Add them before parsing; they must outlive it.
class LookOptions {
  public:
    explicit LookOptions(Tool& tool);

    /// Set look, cuts and background as they were asked for.
    /// @throws ParameterError, InputError naming a transfer function's file
    void apply(RenderParams& params) const;

  private:
    std::string mLook = "flow";
    std::optional<std::string> mTransfer, mColorMap, mOpacity, mShading;
    std::optional<std::array<double, 2>> mRange;
    std::optional<double> mModulate, mLimb, mHalo, mDepthCue;
    std::optional<float> mAmbient, mDiffuse, mSpecular, mShininess, mHeadLight;
    std::vector<std::array<double, 3>> mLights;
    std::vector<std::array<double, 6>> mClipPlanes;
    std::optional<std::array<double, 6>> mClipBox;
    std::optional<std::array<double, 3>> mBackground;
    std::optional<double> mBackgroundAlpha;
};

} // namespace vdblic::cli
