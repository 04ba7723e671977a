#include "vdblic/run/parameter_texts.h"

#include "vdblic/io/file_stamp.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/run/advect_plan.h"

#include <fmt/format.h>

namespace vdblic {

ParameterTexts parameterTexts(const AdvectPlan& plan)
{
    AdvectParams chosen = plan.params;
    chosen.preroll = plan.preroll;
    chosen.leadIn = plan.leadIn;
    chosen.finish = plan.finish;
    ParameterTexts texts;
    for (const Parameter& parameter : parametersOf(chosen)) {
        if (!parameter.info.isContent) continue;
        std::string text = parameter.value();
        if (parameter.key == "noise" && !text.empty())
            text += fmt::format(" ({})", fileStamp(parseGridReference(text).path));
        texts.emplace_back(parameter.key, text);
    }
    // What no tool sets.
    const FeedbackParams& feedback = plan.params.texture.feedback;
    texts.emplace_back("mean_along_flow", fmt::format("{}", feedback.taps));
    texts.emplace_back("deviation", fmt::format("{}", feedback.deviation));
    return texts;
}

} // namespace vdblic
