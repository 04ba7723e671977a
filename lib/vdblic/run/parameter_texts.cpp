#include "vdblic/run/parameter_texts.h"

#include "vdblic/io/file_stamp.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/run/advect_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace vdblic {

namespace {

/// Parameters that do not change the content of textures.
constexpr std::array<std::string_view, 12> kOfFiles = {
    "input", "frames", "clamp_frames", "renumber", "steady_frames",   "output",
    "fps",   "json",   "resume",       "restart",  "keep_checkpoint", "checkpoint_every"};

} // namespace

ParameterTexts parameterTexts(const AdvectPlan& plan)
{
    AdvectParams chosen = chosenParams(plan);
    ParameterTexts texts;
    for (const Parameter& parameter : parametersOf(chosen)) {
        if (std::find(kOfFiles.begin(), kOfFiles.end(), parameter.key) != kOfFiles.end()) continue;
        std::string text = parameter.value();
        if (parameter.key == "noise" && !text.empty())
            text += fmt::format(" ({})", fileStamp(parseGridReference(text).path));
        texts.emplace_back(parameter.key, text);
    }
    // Parameters without an option.
    const FeedbackParams& feedback = plan.params.texture.feedback;
    texts.emplace_back("mean_along_flow", fmt::format("{}", feedback.taps));
    texts.emplace_back("deviation", fmt::format("{}", feedback.deviation));
    return texts;
}

} // namespace vdblic
