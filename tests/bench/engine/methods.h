#pragma once

#include "bench/engine/figures.h"
#include "bench/engine/flow.h"
#include "vdblic/methods/texture_params.h"

#include <nlohmann/json.hpp>

namespace vdblic::bench {

/// Run FlowTexture over a flow, after a preroll of one life span that is not measured.
/// @param coherence whether to measure it, too
[[nodiscard]] Figures runPipeline(const Flow& flow, const TextureParams& scatter, bool coherence);

/// Compare the methods, the paper's order of work included, at a life span of 4: prints a table.
nlohmann::json compareMethods(const Flow& flow, const char* title);

} // namespace vdblic::bench
