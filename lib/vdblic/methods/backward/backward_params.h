#pragma once

#include "vdblic/core/parameters.h"

#include <optional>

namespace vdblic {

/// Parameters of the methods that look back along pathlines, beside TextureParams.
struct BackwardParams {
    /// The share of noise blended in, α of van Wijk 2002 and of Jobard, Erlebacher & Hussaini 2002; nothing:
    /// shareFor().
    std::optional<double> alpha{};

    /// The share per frame: as given, else 4 / (3 L), which gives streaks as long as AUFLIC's of life span L.
    [[nodiscard]] double shareFor(int lifeSpan) const;
    /// The share per step: the steps of a frame together have the frame's share.
    [[nodiscard]] double stepShare(int lifeSpan, int substeps) const;
    /// Frames until the weight of the first texture falls below a fifth.
    [[nodiscard]] int settlingFrames(int lifeSpan) const;

    void validate() const; ///< @throws ParameterError
};
[[nodiscard]] Parameters parametersOf(BackwardParams& params);

} // namespace vdblic
