#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/io/sequence.h"
#include "vdblic/io/velocity.h"
#include "vdblic/lic/feedback.h"
#include "vdblic/lic/scatter.h"

#include <iosfwd>
#include <optional>
#include <string>

namespace vdblic {

/// From a velocity sequence to a texture sequence.
struct AdvectParams {
    SequenceParams input;
    std::string output; ///< pattern of the texture files
    VelocityParams velocity;
    std::optional<double> interval; ///< seconds between frames; nothing: from the files' metadata, else 1/24
    ScatterParams scatter;
    FeedbackParams feedback;
    std::string noise;          ///< FILE or FILE:GRID; empty: generated from the seed
    std::uint32_t seed = 0;     ///< of the generated noise
    std::optional<int> preroll; ///< steps on the frozen first frame before it is written; nothing: the life span
    std::string textureName = "density";

    void validate() const; ///< @throws ParameterError
};

/// Compute and write the texture of every frame; reading ahead, computing and writing overlap.
///
/// @param lines source of the paths if the input is `-`
/// @throws ParameterError, InputError, OutputError; outputs written before stay
void advectSequence(const AdvectParams& params, std::istream& lines, Reporter& reporter);

} // namespace vdblic
