#include "vdblic/coherence/coherence_sequence.h"

#include "vdblic/coherence/coherence.h"
#include "vdblic/coherence/coherence_report.h"
#include "vdblic/coherence/smoothed_texture.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/core/memory.h"
#include "vdblic/field/refinement.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/flow/flow_sequence.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/io/vdb_header.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

MeanFigures meanOf(const std::vector<FrameCoherence>& frames, CoherenceFigures FrameCoherence::*version,
                   std::size_t lags)
{
    const auto estimate = [&](const auto& figure) {
        std::vector<double> values;
        values.reserve(frames.size());
        for (const FrameCoherence& frame : frames)
            values.push_back(figure(frame.*version));
        return estimateMean(values);
    };
    MeanFigures means{};
    for (std::size_t i = 0; i < kNamedFigures.size(); ++i)
        means.figures[i] = estimate([i](const CoherenceFigures& figures) { return figures.*kNamedFigures[i].value; });
    for (std::size_t lag = 0; lag < lags; ++lag) {
        means.along.push_back(estimate([lag](const CoherenceFigures& figures) { return figures.along[lag]; }).mean);
        means.across.push_back(estimate([lag](const CoherenceFigures& figures) { return figures.across[lag]; }).mean);
    }
    return means;
}

MeanCleanness meanOf(const std::vector<FrameCoherence>& frames, std::size_t displacementClass)
{
    MeanCleanness mean{};
    for (const FrameCoherence& frame : frames)
        mean.points += frame.byDisplacement[displacementClass].points;
    for (std::size_t i = 0; i < kCleannessFigures.size(); ++i) {
        std::vector<double> values;
        values.reserve(frames.size());
        for (const FrameCoherence& frame : frames)
            values.push_back(frame.byDisplacement[displacementClass].*kCleannessFigures[i].value);
        mean.figures[i] = estimateMean(values);
    }
    return mean;
}

std::string toString(const Refinement& refinement)
{
    return fmt::format("{}", fmt::join(refinement.factors, " x "));
}

/// A texture read from a file.
struct MeasuredTexture {
    std::filesystem::path path;
    SmoothedTexture texture;
    openvdb::math::Transform::ConstPtr transform;
    std::optional<HitFigures> hits;
    std::string gridName;
    Refinement refinement{}; // of the velocity's voxels
};

template<typename GridT>
std::optional<HitFigures> hitsOf(const VdbFile& file)
{
    const auto grid = file.find<GridT>("hits");
    if (!grid) return std::nullopt;
    double count = 0, sum = 0, zeros = 0;
    for (auto value = grid->cbeginValueOn(); value; ++value) {
        const auto voxels = double(value.getVoxelCount());
        count += voxels;
        sum += voxels * double(*value);
        zeros += *value == 0 ? voxels : 0;
    }
    if (count == 0) return std::nullopt;
    return HitFigures{sum / count, zeros / count};
}

/// @throws InputError naming the grid
SmoothedTexture smoothedTexture(const openvdb::FloatGrid& grid, const std::string& where)
{
    constexpr double kBytes = 40; // a voxel: values, smoothed values, bricks of both
    const double voxels =
        std::max(double(grid.activeVoxelCount()), double(grid.tree().leafCount()) * Domain::kLeafVoxels);
    checkMemory(kBytes * voxels, fmt::format("{}: {} voxels", where, voxels), "take a smaller texture");
    try {
        return SmoothedTexture(grid.tree());
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", where, error.what()));
    }
}

MeasuredTexture readTexture(const std::filesystem::path& path, const std::string& given)
{
    const VdbFile file = readVdb(path);
    const std::string name = textureName(file.metadata, given);
    const auto grid = file.get<openvdb::FloatGrid>(name, "`texture`");
    const std::string where = fmt::format("{}: grid {}", path.string(), name);
    MeasuredTexture loaded{path, smoothedTexture(*grid, where), grid->transformPtr(), hitsOf<openvdb::FloatGrid>(file),
                           name};
    if (!loaded.hits) loaded.hits = hitsOf<openvdb::Int32Grid>(file);
    if (!loaded.hits) loaded.hits = hitsOf<openvdb::Int64Grid>(file);
    if (loaded.texture.domain().voxelCount() > 0 && !std::isfinite(loaded.texture.rawContrast().deviation)) {
        throw InputError(fmt::format(
            "{}: grid {}: there are values that are not finite numbers; make the texture again", path.string(), name));
    }
    return loaded;
}

/// Finds the texture file of a velocity's frame. Textures with substeps have numbers of their own, from the sequence's
/// first frame on.
class TextureFiles {
  public:
    explicit TextureFiles(const SequenceCoherenceParams& params) : mPattern(params.texture)
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
            throw InputError(
                fmt::format("{}: the texture of frame {} is missing, its velocity is {}; choose frames that "
                            "both have with `frames`",
                            path(file.frame).string(), file.frame, file.path.string()));
        }
        if (!mPattern.hasField() || !params.flow.input.frames.empty()) return;
        for (const std::int64_t number : mPattern.framesOnDisk()) {
            if ((number - mFirst) % mSubsteps != 0) continue; // between two frames
            const std::int64_t frame = mFirst + (number - mFirst) / mSubsteps;
            std::error_code ignored;
            if (std::filesystem::exists(velocity.path(frame), ignored)) continue;
            throw InputError(
                fmt::format("{}: the velocity of frame {} is missing, its texture is {}; choose frames that "
                            "both have with `frames`",
                            velocity.path(frame).string(), frame, path(frame).string()));
        }
    }

    [[nodiscard]] std::filesystem::path path(std::int64_t frame) const
    {
        return mPattern.hasField() ? mPattern.path(mFirst + (frame - mFirst) * mSubsteps)
                                   : std::filesystem::path(mPattern.text());
    }

    /// VelocityParams::motion that the textures were made with.
    [[nodiscard]] double motion() const { return mMotion; }

  private:
    /// Read from some texture how the textures are numbered, and how far their flow moves.
    void readFirst()
    {
        const std::vector<std::int64_t> numbers =
            mPattern.hasField() ? mPattern.framesOnDisk() : std::vector<std::int64_t>{1};
        std::error_code ignored;
        if (numbers.empty() || !std::filesystem::exists(mPattern.path(numbers.front()), ignored)) return;
        const openvdb::MetaMap metadata = readVdbHeader(mPattern.path(numbers.front())).metadata;
        mMotion = numericMetadata(metadata, "motion").value_or(1);
        const double substeps = numericMetadata(metadata, "substeps").value_or(1);
        const auto source = numericMetadata(metadata, "source_frame"), number = numericMetadata(metadata, "frame");
        constexpr double kMost = 64;
        if (!(substeps > 1 && substeps <= kMost) || !source || !number) return;
        mSubsteps = std::int64_t(substeps);
        mFirst = std::llround((double(mSubsteps) * *source - *number) / double(mSubsteps - 1));
    }

    FramePattern mPattern;
    std::int64_t mSubsteps = 1, mFirst = 0; // textures to a frame; the frame whose texture has the same number
    double mMotion = 1;
};

/// Read the texture of a velocity's frame, which must have the velocity's transform or a refined one.
MeasuredTexture textureOf(const LoadedFrame& frame, const TextureFiles& files, const std::string& name)
{
    const VelocityFrame& velocity = frame.velocity;
    MeasuredTexture loaded = readTexture(files.path(velocity.file.frame), name);
    const auto refinement = Refinement::between(velocity.values->transform(), *loaded.transform);
    if (!refinement) {
        throw InputError(
            fmt::format("{}: grid {}: its transform is neither that of grid {} of {} nor a refinement of it; "
                        "give the velocity that the texture was made from",
                        loaded.path.string(), loaded.gridName, velocity.gridName, velocity.file.path.string()));
    }
    loaded.refinement = *refinement;
    return loaded;
}

/// Read the texture after another one, which must have the same transform.
MeasuredTexture successorOf(const MeasuredTexture& before, const LoadedFrame& frame, const TextureFiles& files,
                            const std::string& name)
{
    MeasuredTexture loaded = textureOf(frame, files, name);
    if (loaded.refinement == before.refinement) return loaded;
    throw InputError(fmt::format("{}: grid {}: {} texture voxels fill a voxel of the velocity, in {} {}; make all "
                                 "textures with one refinement",
                                 loaded.path.string(), loaded.gridName, toString(loaded.refinement),
                                 before.path.string(), toString(before.refinement)));
}

void checkFurtherOutput(const std::string& output, const SequenceCoherenceParams& params, const TextureFiles& textures)
{
    if (output.empty()) return;
    checkReport(output);
    for (const FrameFile& velocity : selectFrames(params.flow.input)) {
        checkNotInput(output, velocity.path);
        checkNotInput(output, textures.path(velocity.frame));
    }
}

} // namespace

SequenceCoherence coherenceOfSequence(const SequenceCoherenceParams& params, Reporter& reporter)
{
    params.validate();
    const TextureFiles files(params);
    checkFurtherOutput(params.json, params, files);
    checkFurtherOutput(params.plot, params, files);
    if (!params.json.empty() && !params.plot.empty()) checkDistinct(params.json, params.plot);
    std::istringstream noLines;
    const OneProcess alone;
    std::size_t total = 0;
    FlowSequence flow(params.flow, openSequence(params.flow.input, noLines, total), reporter, alone);
    flow.setMotion(files.motion());

    SequenceCoherence result;
    std::optional<LoadedFrame> current = flow.next(), next;
    std::optional<MeasuredTexture> texture, nextTexture;
    if (current) {
        texture = textureOf(*current, files, params.textureName);
        result.refine = texture->refinement.factors;
        result.lags = coherenceLags(result.refine);
        if (!texture->refinement.isNone()) {
            reporter.say(
                fmt::format("{} texture voxels fill a voxel of the velocity; lags and lengths are in voxels of the "
                            "velocity",
                            toString(texture->refinement)));
        }
    }
    reporter.say(frameHeading());
    for (; current; current = std::move(next), texture = std::move(nextTexture)) {
        reporter.checkStop();
        next = flow.next();
        nextTexture = std::nullopt;
        if (next) nextTexture = successorOf(*texture, *next, files, params.textureName);
        const LoadedFrame& end = next ? *next : *current;
        const FrameInterval interval = flow.intervalAfter(*current, next ? &*next : nullptr);
        if (result.frames.empty())
            flow.describe(*current, interval, current->velocity.largestDisplacement(interval.seconds));
        VelocityField field;
        field.build({texture->texture.sharedDomain(), current->domain.velocity, texture->refinement},
                    {current->velocity.values->tree(), current->velocity.toVoxelsPerStep(interval.seconds)},
                    {end.velocity.values->tree(), end.velocity.toVoxelsPerStep(interval.seconds)});
        FrameCoherence frame = measureCoherence(texture->texture, nextTexture ? &nextTexture->texture : nullptr, field,
                                                params.coherence, current->velocity.file.frame);
        frame.hits = texture->hits;
        reporter.say(frameLine(frame));
        if (frame.points == 0) {
            reporter.warn(fmt::format("frame {}: nowhere inside does the flow move by {} voxels a step; check unit and "
                                      "frame spacing",
                                      frame.frame, params.coherence.leastMotion));
        }
        result.frames.push_back(frame);
        reporter.progress(result.frames.size(), total);
    }
    result.raw = meanOf(result.frames, &FrameCoherence::raw, result.lags.size());
    result.smoothed = meanOf(result.frames, &FrameCoherence::smoothed, result.lags.size());
    for (std::size_t i = 0; i < result.byDisplacement.size(); ++i)
        result.byDisplacement[i] = meanOf(result.frames, i);
    for (const std::string& line : meanLines(result))
        reporter.say(line);
    for (const std::string& line : displacementLines(result))
        reporter.say(line);

    if (!params.json.empty()) {
        if (writeReport(params.json, toJson(result, params))) reporter.finished(params.json);
    }
    if (!params.plot.empty()) {
        if (writeReport(params.plot, toSvg(result))) reporter.finished(params.plot);
    }
    return result;
}

} // namespace vdblic
