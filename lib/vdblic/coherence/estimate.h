#pragma once

#include <vector>

namespace vdblic {

/// The mean of a figure over frames, and how far the true mean may be from it.
struct Estimate {
    double mean;      ///< over the frames that have the figure; not-a-number if none has
    double halfWidth; ///< of the 95 % confidence interval; not-a-number for fewer than two frames
    int frames;       ///< that have the figure
};

/// Estimate a mean by Student's t distribution from the spread of the values, assumed independent.
/// @param values not-a-number where a frame lacks the figure
[[nodiscard]] Estimate estimateMean(const std::vector<double>& values);

} // namespace vdblic
