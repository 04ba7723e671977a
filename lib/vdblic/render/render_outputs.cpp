#include "vdblic/render/render_outputs.h"

#include "vdblic/io/atomic_file.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/render/render_plan.h"

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>

namespace vdblic {
namespace {

void checkFurtherOutput(const std::string& report, const RenderPlan& plan, const std::vector<FrameFile>& files)
{
    if (report.empty()) return;
    for (const std::string& input : {plan.picture.cameraFile, plan.picture.region}) {
        if (!input.empty()) checkNotInput(report, parseGridReference(input).path);
    }
    for (const FrameFile& file : files)
        checkNotInput(report, file.path);
    if (!plan.outputs.images.empty()) checkNoFrame(report, FramePattern(plan.outputs.images));
    checkReport(report);
}

} // namespace

void checkRenderOutputs(const RenderPlan& plan, const std::vector<FrameFile>& files)
{
    const std::string* const further[] = {&plan.outputs.histogram, &plan.outputs.transferFunction, &plan.outputs.film};
    for (std::size_t i = 0; i < std::size(further); ++i) {
        checkFurtherOutput(*further[i], plan, files);
        for (std::size_t j = 0; j < i; ++j) {
            if (!further[i]->empty() && !further[j]->empty()) checkDistinct(*further[i], *further[j]);
        }
    }
    if (!plan.outputs.film.empty()) checkOutput(plan.outputs.film);
    if (plan.outputs.images.empty() || files.empty()) return;
    std::vector<std::int64_t> frames;
    frames.reserve(files.size());
    for (const FrameFile& file : files)
        frames.push_back(file.frame);
    checkOutputs(FramePattern(plan.outputs.images), frames);
}

} // namespace vdblic
