#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/field/domain_mask.h"
#include "vdblic/io/sequence.h"
#include "vdblic/io/velocity.h"
#include "vdblic/lic/feedback.h"
#include "vdblic/lic/scatter.h"
#include "vdblic/lic/steady_lic.h"

#include <iosfwd>
#include <optional>
#include <string>

namespace vdblic {

/// Displacements beyond this many voxels a step are warned of: over such a way the velocity is hardly linear in time.
inline constexpr double kLargeDisplacement = 16;

/// From a velocity sequence to a texture sequence.
struct AdvectParams {
    SequenceParams input;
    std::string output; ///< pattern of the texture files
    VelocityParams velocity;
    std::optional<double> frameSpacing; ///< seconds between frames on disk; nothing: by metadata, else 1/24
    DomainParams domain;
    ScatterParams scatter;
    FeedbackParams feedback;
    std::optional<LicKernel> steady; ///< LIC of each frame on its own, instead of scatter.method
    std::string noise;               ///< FILE or FILE:GRID; empty: generated from the seed
    std::uint32_t seed = 1;          ///< of the generated noise
    std::optional<int>
        preroll; ///< steps on the frozen first frame before it is written; nothing: the life span, 0 for LIC
    std::string textureName = "density";
    std::vector<std::string> derived{}; ///< further grids made of the velocity, by kDerivedNames

    void validate() const; ///< @throws ParameterError
};

/// Compute and write the texture of every frame: `density`, `magnitude`, derived grids, what is carried along; reading
/// ahead, computing and writing overlap.
///
/// @param lines source of the paths if the input is `-`
/// @throws ParameterError, InputError, OutputError; outputs written before stay
void advectSequence(const AdvectParams& params, std::istream& lines, Reporter& reporter);

} // namespace vdblic
