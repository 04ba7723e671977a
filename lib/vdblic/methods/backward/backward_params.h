#pragma once

#include "vdblic/core/parameters.h"

#include <optional>

namespace vdblic {

/// What the methods that look back along pathlines ask for beside TextureParams.
struct BackwardParams {
    /// Share of the noise that is blended in, α of van Wijk 2002 and of Jobard, Erlebacher & Hussaini 2002; nothing:
    /// shareFor().
    std::optional<double> alpha{};

    /// The share of a frame: as given, else 4 / (3 L), with which streaks are as long as AUFLIC's of life span L.
    [[nodiscard]] double shareFor(int lifeSpan) const;
    /// That of one of several steps in a frame, which together have the share of a frame.
    [[nodiscard]] double stepShare(int lifeSpan, int substeps) const;
    /// Frames until the weight of the first texture falls below a fifth.
    [[nodiscard]] int settlingFrames(int lifeSpan) const;

    void validate() const; ///< @throws ParameterError
};
[[nodiscard]] Parameters parametersOf(BackwardParams& params);

} // namespace vdblic
