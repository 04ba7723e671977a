#pragma once

#include "vdblic/lines/lines.h"

namespace vdblic {

/// The lines of a sequence at a moment between two frames.
///
/// The particle of a line is where its path in the later frame has it at that time, and the tail behind it joins the
/// paths of both frames. Opacity and radius by age, and the scalars of a place, change evenly from one frame to the
/// other. A line that only one of the frames has fades in or out. Two lines of one id are two particles if the later
/// line begins after the earlier one ends. Computed in parallel; the result does not depend on the number of threads.
/// @param before, after with ascending ids  @param share of the way from `before` to `after`, above 0 and below 1
/// @param interval between the two frames, in the units of ages
[[nodiscard]] Lines linesBetween(const Lines& before, const Lines& after, double share, double interval);

} // namespace vdblic
