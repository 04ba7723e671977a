#include "vdblic/render/render_outputs.h"

#include "vdblic/io/atomic_file.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/render/render_params.h"

#include <cstdint>
#include <string>

namespace vdblic {
namespace {

void checkFurtherOutput(const std::string& report, const RenderParams& params, const std::vector<FrameFile>& files)
{
    if (report.empty()) return;
    for (const std::string& input : {params.motion.keys.string(), params.region}) {
        if (!input.empty()) checkNotInput(report, parseGridReference(input).path);
    }
    for (const FrameFile& file : files)
        checkNotInput(report, file.path);
    if (!params.output.empty()) checkNoFrame(report, FramePattern(params.output));
    checkReport(report);
}

} // namespace

void checkRenderOutputs(const RenderParams& params, const std::vector<FrameFile>& files)
{
    checkFurtherOutput(params.histogram, params, files);
    checkFurtherOutput(params.transferOut, params, files);
    if (!params.histogram.empty() && !params.transferOut.empty()) checkDistinct(params.histogram, params.transferOut);
    if (params.output.empty() || files.empty()) return;
    std::vector<std::int64_t> frames;
    frames.reserve(files.size());
    for (const FrameFile& file : files)
        frames.push_back(file.frame);
    checkOutputs(FramePattern(params.output), frames);
}

} // namespace vdblic
