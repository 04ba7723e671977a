#pragma once

#include "vdblic/compare/compare.h"

#include <string>
#include <vector>

namespace vdblic {

/// "same", "warning" or "different".
[[nodiscard]] std::string toText(Verdict verdict);

/// Lines of text: a frame's verdict and its differences.
[[nodiscard]] std::vector<std::string> reportLines(const FrameDifference& frame);
/// Lines of text: the figures of a frame's grids that are equal within tolerance.
[[nodiscard]] std::vector<std::string> detailLines(const FrameDifference& frame);

/// The whole difference as JSON, indented by two spaces (docs/measure.md).
///
/// Numbers that JSON lacks are the strings "inf", "-inf" and "nan".
[[nodiscard]] std::string toJson(const SequenceDifference& difference, const CompareParams& params);

} // namespace vdblic
