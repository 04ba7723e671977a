#include "vdblic/run/run_outputs.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/run/advect_params.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace vdblic {

namespace {

/// Runs over parts of a sequence have checkpoints of their own, so that they can share a folder.
std::string checkpointName(const AdvectParams& params)
{
    if (params.leadIn.value_or(0) == 0 && params.framesBefore == 0) return "checkpoint";
    const std::int64_t first = selectedFrames(params.input).at(std::size_t(params.leadIn.value_or(0)));
    return fmt::format("checkpoint.{:04}", first);
}

} // namespace

RunOutputs::RunOutputs(const AdvectParams& params)
    : mParams(params), mTextures(params.output), mCheckpoint(mTextures.companion(checkpointName(params)))
{
}

std::int64_t RunOutputs::number(std::int64_t frame, int part) const
{
    const std::int64_t first = mFirst.value_or(frame);
    std::int64_t number = 0;
    if (__builtin_sub_overflow(frame, first, &number) ||
        __builtin_mul_overflow(number, std::int64_t(mParams.scatter.substeps), &number) ||
        __builtin_add_overflow(number, first, &number) || __builtin_add_overflow(number, std::int64_t(part), &number)) {
        throw ParameterError(
            fmt::format("frame {} has no number in a sequence of {} `substeps` that starts at frame {}", frame,
                        mParams.scatter.substeps, first));
    }
    return number;
}

std::filesystem::path RunOutputs::checkpointPart(std::uint64_t steps, std::size_t part) const
{
    const std::string stem = mCheckpoint.stem().string();
    return mCheckpoint.parent_path() / fmt::format("{}.s{}.p{}.vdb", stem, steps, part);
}

std::vector<std::filesystem::path> RunOutputs::checkpointParts(std::optional<std::uint64_t> but) const
{
    const std::string stem = mCheckpoint.stem().string() + ".s";
    const std::filesystem::path folder = mCheckpoint.parent_path();
    std::vector<std::filesystem::path> parts;
    for (const auto& entry : std::filesystem::directory_iterator(folder.empty() ? "." : folder)) {
        unsigned long long steps = 0;
        unsigned long long part = 0;
        int end = 0;
        const std::string name = entry.path().filename().string();
        if (!name.starts_with(stem)) continue;
        if (std::sscanf(name.c_str() + stem.size(), "%llu.p%llu.vdb%n", &steps, &part, &end) != 2 || end == 0 ||
            name.size() != stem.size() + std::size_t(end) || steps == but)
            continue;
        parts.push_back(entry.path());
    }
    return parts;
}

void RunOutputs::check(std::size_t textures)
{
    if (textures > 0) checkOutputPattern(mTextures, textures);
    checkOutput(mCheckpoint);
    if (mParams.input.pattern != "-") {
        const std::vector<std::int64_t> frames = selectedFrames(mParams.input);
        for (auto frame = frames.begin() + mParams.leadIn.value_or(0); frame != frames.end(); ++frame) {
            startAt(*frame);
            for (int part = 0; part < mParams.scatter.substeps; ++part)
                checkReplaceable(texture(*frame, part));
        }
    }
    if (mParams.json.empty()) return;
    checkNoFrame(mParams.json, mTextures);
    checkDistinct(mParams.json, mCheckpoint);
    checkReport(mParams.json); // found out now, not after hours
}

void RunOutputs::checkInputs(const FrameFile& velocity) const
{
    std::vector<std::string> references = {mParams.noise, mParams.domain.mask};
    for (std::string& reference : references) {
        if (!reference.empty()) reference = parseGridReference(reference).path.string();
    }
    if (mParams.input.pattern != "-") references.push_back(mParams.input.pattern);
    for (int part = 0; part < mParams.scatter.substeps; ++part) {
        const std::int64_t output = number(velocity.frame, part);
        std::vector<std::filesystem::path> inputs = {velocity.path};
        for (const std::string& reference : references) {
            if (!reference.empty()) inputs.push_back(FramePattern(reference).path(output));
        }
        checkReplaceable(texture(velocity.frame, part));
        for (const std::filesystem::path& input : inputs) {
            checkNotInput(texture(velocity.frame, part), input);
            checkNotInput(mCheckpoint, input);
            if (!mParams.json.empty()) checkNotInput(mParams.json, input);
        }
    }
}

} // namespace vdblic
