#include "vdblic/render/render_outputs.h"

#include "vdblic/io/atomic_file.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/input_files.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/render/render_plan.h"

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>

namespace vdblic {
namespace {

InputFiles inputsOf(const RenderPlan& plan, const std::vector<FrameFile>& files)
{
    InputFiles inputs;
    inputs.add(plan.picture.cameraFile);
    inputs.add(plan.picture.transferFile);
    for (const std::string& reference : {plan.picture.region, plan.picture.solid.source}) {
        if (reference.empty()) continue;
        const std::string path = parseGridReference(reference).path.string();
        inputs.add(path);
        for (const FrameFile& file : files)
            inputs.add(FramePattern(path).path(file.frame));
    }
    for (const FrameFile& file : files)
        inputs.add(file.path);
    return inputs;
}

void checkFurtherOutput(const std::string& report, const RenderPlan& plan, const InputFiles& inputs)
{
    if (report.empty()) return;
    inputs.check(report);
    if (!plan.outputs.images.empty()) checkNoFrame(report, FramePattern(plan.outputs.images));
    checkReport(report);
}

} // namespace

void checkRenderOutputs(const RenderPlan& plan, const std::vector<FrameFile>& files)
{
    const InputFiles inputs = inputsOf(plan, files);
    const std::string* const further[] = {&plan.outputs.histogram, &plan.outputs.transferFunction, &plan.outputs.film};
    for (std::size_t i = 0; i < std::size(further); ++i) {
        checkFurtherOutput(*further[i], plan, inputs);
        for (std::size_t j = 0; j < i; ++j) {
            if (!further[i]->empty() && !further[j]->empty()) checkDistinct(*further[i], *further[j]);
        }
    }
    if (!plan.outputs.film.empty()) checkOutput(plan.outputs.film);
    if (plan.outputs.images.empty() || files.empty()) return;
    std::vector<std::int64_t> frames;
    frames.reserve(files.size());
    for (const FrameFile& file : files) {
        frames.push_back(file.frame);
        inputs.check(FramePattern(plan.outputs.images).path(file.frame));
    }
    checkOutputs(FramePattern(plan.outputs.images), frames);
}

} // namespace vdblic
