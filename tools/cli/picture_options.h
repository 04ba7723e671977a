#pragma once

#include "cli/look_options.h"
#include "vdblic/render/render_params.h"

#include <CLI/CLI.hpp>

#include <string>

namespace vdblic::cli {

/// The options that determine a picture: texture, size, camera, sampling, look, cuts, solid and annotations.
///
/// Construct before parsing. This and the parameters must outlive the parsing.
class PictureOptions {
  public:
    PictureOptions(CLI::App& app, RenderParams& params);

    /// Set what the options say in the parameters. @throws ParameterError; InputError naming a file
    void apply() const;

  private:
    RenderParams& mParams;
    std::string mProjection, mKeys, mAnnotations;
    LookOptions mLook;
};

} // namespace vdblic::cli
