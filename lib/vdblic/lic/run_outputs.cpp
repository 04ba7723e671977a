#include "vdblic/lic/run_outputs.h"

#include "vdblic/io/atomic_file.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/lic/advect_params.h"

#include <string>
#include <vector>

namespace vdblic {

RunOutputs::RunOutputs(const AdvectParams& params)
    : mParams(params), mTextures(params.output), mCheckpoint(mTextures.companion("checkpoint"))
{
}

void RunOutputs::check(std::size_t frames) const
{
    if (frames > 0) checkOutputPattern(mTextures, frames);
    if (mParams.json.empty()) return;
    checkNoFrame(mParams.json, mTextures);
    checkDistinct(mParams.json, mCheckpoint);
    AtomicFile{mParams.json}; // found out now, not after hours
}

void RunOutputs::checkInputs(const FrameFile& velocity) const
{
    std::vector<std::filesystem::path> inputs = {velocity.path};
    for (const std::string& reference : {mParams.noise, mParams.domain.mask}) {
        if (reference.empty()) continue;
        inputs.push_back(FramePattern(parseGridReference(reference).path.string()).path(velocity.frame));
    }
    for (const std::filesystem::path& input : inputs) {
        checkNotInput(texture(velocity.frame), input);
        checkNotInput(mCheckpoint, input);
        if (!mParams.json.empty()) checkNotInput(mParams.json, input);
    }
}

} // namespace vdblic
