#include "vdblic/coherence/estimate.h"

#include <boost/math/distributions/students_t.hpp>

#include <cmath>
#include <limits>

namespace vdblic {

Estimate estimateMean(const std::vector<double>& values)
{
    constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
    Estimate result{kUnknown, kUnknown, 0};
    double sum = 0, squares = 0;
    for (const double value : values) {
        if (std::isnan(value)) continue;
        sum += value;
        ++result.frames;
    }
    if (result.frames == 0) return result;
    result.mean = sum / result.frames;
    if (result.frames == 1) return result;
    for (const double value : values) {
        if (!std::isnan(value)) squares += (value - result.mean) * (value - result.mean);
    }
    const double variance = squares / (result.frames - 1);
    const boost::math::students_t student(result.frames - 1);
    constexpr double kTail = 0.025; // on each side of 95 %
    result.halfWidth = quantile(complement(student, kTail)) * std::sqrt(variance / result.frames);
    return result;
}

} // namespace vdblic
