#include "vdblic/run/run_outputs.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/checkpoint_mark.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/input_files.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/run/advect_plan.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace vdblic {

namespace {

/// Runs over parts of a sequence have checkpoints of their own, so that they can share a folder.
std::string checkpointName(const AdvectPlan& plan)
{
    if (plan.leadIn == 0 && plan.framesBefore == 0) return "checkpoint";
    const std::int64_t first = selectedFrames(plan.input).at(std::size_t(plan.leadIn));
    return fmt::format("checkpoint.{:04}", first);
}

} // namespace

RunOutputs::RunOutputs(const AdvectPlan& plan)
    : RunOutputs(plan, FramePattern(plan.params.output).companion(checkpointName(plan)))
{
}

RunOutputs::RunOutputs(const AdvectPlan& plan, std::filesystem::path checkpoint)
    : mPlan(plan), mParams(plan.params), mTextures(plan.params.output), mCheckpoint(std::move(checkpoint))
{
}

std::int64_t textureNumber(std::int64_t first, std::int64_t frame, int substeps, int substep)
{
    std::int64_t number = 0;
    if (__builtin_sub_overflow(frame, first, &number) ||
        __builtin_mul_overflow(number, std::int64_t(substeps), &number) ||
        __builtin_add_overflow(number, first, &number) ||
        __builtin_add_overflow(number, std::int64_t(substep), &number)) {
        throw ParameterError(fmt::format(
            "frame {} has no number in a sequence of {} `substeps` that starts at frame {}", frame, substeps, first));
    }
    return number;
}

std::int64_t RunOutputs::number(std::int64_t frame, int substep) const
{
    return textureNumber(mFirst.value_or(frame), frame, mPlan.substeps(), substep);
}

std::filesystem::path RunOutputs::lock() const
{
    return mCheckpoint.parent_path() / fmt::format(".{}.lock", mCheckpoint.stem().string());
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
    std::error_code error;
    std::filesystem::directory_iterator entry(folder.empty() ? "." : folder, error);
    for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
        unsigned long long steps = 0;
        unsigned long long part = 0;
        int end = 0;
        const std::string name = entry->path().filename().string();
        if (!name.starts_with(stem)) continue;
        if (std::sscanf(name.c_str() + stem.size(), "%llu.p%llu.vdb%n", &steps, &part, &end) != 2 || end == 0 ||
            name.size() != stem.size() + std::size_t(end) || steps == but)
            continue;
        parts.push_back(entry->path());
    }
    if (error) throw OutputError(fmt::format("{}: cannot be listed: {}", folder.string(), error.message()));
    return parts;
}

void RunOutputs::check(std::size_t textures)
{
    if (textures > 0) checkOutputPattern(mTextures, textures);
    checkCheckpoint(mCheckpoint); // RunCheckpoint::find() reports an existing file
    if (mPlan.input.pattern != "-") {
        const std::vector<std::int64_t> frames = selectedFrames(mPlan.input);
        const FramePattern input(mPlan.input.pattern);
        InputFiles inputs;
        for (const std::int64_t frame : frames)
            inputs.add(input.path(frame));
        for (auto frame = frames.begin() + mPlan.leadIn; frame != frames.end(); ++frame) {
            startAt(*frame);
            for (int substep = 0; substep < mPlan.substeps(); ++substep) {
                checkReplaceable(texture(*frame, substep));
                inputs.check(texture(*frame, substep));
            }
        }
    }
    if (mParams.json.empty()) return;
    checkNoFrame(mParams.json, mTextures);
    checkDistinct(mParams.json, mCheckpoint);
    checkReport(mParams.json); // fails early
}

void RunOutputs::checkInputs(const FrameFile& velocity) const
{
    std::vector<std::string> references = {mParams.noise, mParams.flow.domain.mask, mParams.streaks.emit};
    for (const StreakSource& source : sourcesOf(mParams.streaks))
        references.push_back(source.grid);
    for (std::string& reference : references) {
        if (!reference.empty()) reference = parseGridReference(reference).path.string();
    }
    if (mPlan.input.pattern != "-") references.push_back(mPlan.input.pattern);
    for (int substep = 0; substep < mPlan.substeps(); ++substep) {
        const std::int64_t output = number(velocity.frame, substep);
        std::vector<std::filesystem::path> inputs = {velocity.path};
        for (const std::string& reference : references) {
            if (!reference.empty()) inputs.push_back(FramePattern(reference).path(output));
        }
        checkReplaceable(texture(velocity.frame, substep));
        for (const std::filesystem::path& input : inputs) {
            checkNotInput(texture(velocity.frame, substep), input);
            checkNotInput(mCheckpoint, input);
            if (!mParams.json.empty()) checkNotInput(mParams.json, input);
        }
    }
}

} // namespace vdblic
