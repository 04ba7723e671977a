#include "vdblic/run/parameter_texts.h"

#include "vdblic/io/file_stamp.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/run/advect_params.h"

#include <fmt/format.h>

namespace vdblic {

ParameterTexts parameterTexts(const AdvectParams& params)
{
    AdvectParams chosen = params;
    chosen.preroll = params.prerollFrames();
    chosen.leadIn = params.leadInFrames();
    chosen.finish = params.finishTaps();
    ParameterTexts texts;
    for (const Parameter& parameter : parametersOf(chosen)) {
        if (!parameter.info.isContent) continue;
        std::string text = parameter.value();
        if (parameter.key == "noise" && !text.empty())
            text += fmt::format(" ({})", fileStamp(parseGridReference(text).path));
        texts.emplace_back(parameter.key, text);
    }
    // What no tool sets.
    const FeedbackParams& feedback = params.texture.feedback;
    texts.emplace_back("mean_along_flow", fmt::format("{}", feedback.taps));
    texts.emplace_back("deviation", fmt::format("{}", feedback.deviation));
    return texts;
}

} // namespace vdblic
