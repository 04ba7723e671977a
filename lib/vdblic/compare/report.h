#pragma once

#include "vdblic/compare/compare.h"

#include <string>
#include <vector>

namespace vdblic {

/// "same", "warning" or "different".
[[nodiscard]] std::string toText(Verdict verdict);

/// A frame's verdict and what differs, in words, line by line.
[[nodiscard]] std::vector<std::string> reportLines(const FrameDifference& frame);
/// The figures of a frame's grids that are the same within tolerance, line by line.
[[nodiscard]] std::vector<std::string> detailLines(const FrameDifference& frame);

/// Everything that is known, as JSON with two spaces of indentation (docs/diff.md).
///
/// Numbers that JSON does not know are the strings "inf", "-inf" and "nan".
[[nodiscard]] std::string toJson(const SequenceDifference& difference, const CompareParams& params);

} // namespace vdblic
