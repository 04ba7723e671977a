#include "vdblic/render/render_outputs.h"

#include "vdblic/io/atomic_file.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/render/render_params.h"

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>

namespace vdblic {
namespace {

void checkFurtherOutput(const std::string& report, const RenderParams& params, const std::vector<FrameFile>& files)
{
    if (report.empty()) return;
    for (const std::string& input : {params.motion.keys.file.string(), params.region}) {
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
    const std::string* const further[] = {&params.histogram, &params.transferOut, &params.film};
    for (std::size_t i = 0; i < std::size(further); ++i) {
        checkFurtherOutput(*further[i], params, files);
        for (std::size_t j = 0; j < i; ++j) {
            if (!further[i]->empty() && !further[j]->empty()) checkDistinct(*further[i], *further[j]);
        }
    }
    if (!params.film.empty()) checkOutput(params.film);
    if (params.output.empty() || files.empty()) return;
    std::vector<std::int64_t> frames;
    frames.reserve(files.size());
    for (const FrameFile& file : files)
        frames.push_back(file.frame);
    checkOutputs(FramePattern(params.output), frames);
}

} // namespace vdblic
