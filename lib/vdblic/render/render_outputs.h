#pragma once

#include "vdblic/io/sequence.h"

#include <vector>

namespace vdblic {

struct RenderPlan;

/// Check, before any work, that the outputs of a run can be written, differ from each other and replace no input.
/// @param files of the input; empty if they come on standard input
/// @throws ParameterError, OutputError
void checkRenderOutputs(const RenderPlan& plan, const std::vector<FrameFile>& files);

} // namespace vdblic
