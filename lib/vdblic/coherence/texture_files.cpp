#include "vdblic/coherence/texture_files.h"

#include "vdblic/coherence/coherence_sequence.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/io/vdb_header.h"

#include <fmt/format.h>

#include <cmath>
#include <system_error>
#include <tuple>
#include <vector>

namespace vdblic {

TextureFiles::TextureFiles(const SequenceCoherenceParams& params) : mPattern(params.texture)
{
    const FramePattern velocity(params.flow.input.pattern);
    if (velocity.hasField() != mPattern.hasField()) {
        const auto& [file, pattern] = velocity.hasField() ? std::tie(mPattern.text(), velocity.text())
                                                          : std::tie(velocity.text(), mPattern.text());
        throw ParameterError(fmt::format("'{}' is one file and '{}' is a pattern; give a file with a file and a "
                                         "sequence with a sequence",
                                         file, pattern));
    }
    readFirst();
    const std::vector<FrameFile> velocities = selectFrames(params.flow.input);
    for (const FrameFile& file : velocities) {
        std::error_code ignored;
        if (std::filesystem::exists(path(file.frame), ignored)) continue;
        throw InputError(fmt::format("{}: the texture of frame {} is missing, its velocity is {}; choose frames that "
                                     "both have with `frames`",
                                     path(file.frame).string(), file.frame, file.path.string()));
    }
    if (!mPattern.hasField() || !params.flow.input.frames.empty()) return;
    for (const std::int64_t number : mPattern.framesOnDisk()) {
        if ((number - mFirst) % mSubsteps != 0) continue; // between two frames
        const std::int64_t frame = mFirst + (number - mFirst) / mSubsteps;
        std::error_code ignored;
        if (std::filesystem::exists(velocity.path(frame), ignored)) continue;
        throw InputError(fmt::format("{}: the velocity of frame {} is missing, its texture is {}; choose frames that "
                                     "both have with `frames`",
                                     velocity.path(frame).string(), frame, path(frame).string()));
    }
}

std::filesystem::path TextureFiles::path(std::int64_t frame) const
{
    return mPattern.hasField() ? mPattern.path(mFirst + (frame - mFirst) * mSubsteps)
                               : std::filesystem::path(mPattern.text());
}

/// Read the numbering and the step of the textures from one of them.
void TextureFiles::readFirst()
{
    const std::vector<std::int64_t> numbers =
        mPattern.hasField() ? mPattern.framesOnDisk() : std::vector<std::int64_t>{1};
    std::error_code ignored;
    if (numbers.empty() || !std::filesystem::exists(mPattern.path(numbers.front()), ignored)) return;
    const openvdb::MetaMap metadata = readVdbHeader(mPattern.path(numbers.front())).metadata;
    mMotion = numericMetadata(metadata, "motion").value_or(1);
    mObserver = ReferenceFrame::describedIn(metadata);
    try {
        mObserver.validate();
    } catch (const ParameterError& error) {
        throw InputError(fmt::format("{}: its metadata: {}", mPattern.path(numbers.front()).string(), error.what()));
    }
    mAreSparse = isSparse(metadata);
    const double substeps = numericMetadata(metadata, "substeps").value_or(1);
    const auto source = numericMetadata(metadata, "source_frame"), number = numericMetadata(metadata, "frame");
    constexpr double kMost = 256; // TextureParams::kMostSubsteps
    if (!(substeps > 1 && substeps <= kMost) || !source || !number) return;
    mSubsteps = std::int64_t(substeps);
    mFirst = std::llround((double(mSubsteps) * *source - *number) / double(mSubsteps - 1));
}

} // namespace vdblic
