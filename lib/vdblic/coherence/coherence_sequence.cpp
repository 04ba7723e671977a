#include "vdblic/coherence/coherence_sequence.h"

#include "vdblic/coherence/coherence.h"
#include "vdblic/coherence/coherence_report.h"
#include "vdblic/coherence/smoothed_texture.h"
#include "vdblic/coherence/sparse_coherence.h"
#include "vdblic/coherence/texture_files.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/paging.h"
#include "vdblic/field/refinement.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/flow/flow_step.h"
#include "vdblic/flow/velocity_sequence.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/lic/hits.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
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
    const auto grid = file.find<GridT>(kHitsGrid);
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
    if (!paging::makeRoom(kBytes * voxels))
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

/// The refinement of a texture. @throws InputError if its transform is neither the velocity's nor a refinement of it
Refinement refinementOf(const VelocityFrame& velocity, const openvdb::math::Transform& texture,
                        const std::filesystem::path& path, const std::string& gridName)
{
    const openvdb::math::Transform& voxels = velocity.values->transform();
    for (const auto& place : {velocity.inWorld(voxels), voxels.copy()}) { // the latter if it stays with the observer
        if (const auto refinement = Refinement::between(*place, texture)) return *refinement;
    }
    throw InputError(fmt::format("{}: grid {}: its transform is neither that of grid {} of {} nor a refinement of it; "
                                 "give the velocity that the texture was made from",
                                 path.string(), gridName, velocity.gridName, velocity.file.path.string()));
}

[[noreturn]] void refuseRefinement(const std::filesystem::path& path, const std::string& gridName,
                                   const Refinement& refinement, const std::filesystem::path& before,
                                   const Refinement& beforeRefinement)
{
    throw InputError(fmt::format("{}: grid {}: {} texture voxels fill a voxel of the velocity, in {} {}; make all "
                                 "textures with one refinement",
                                 path.string(), gridName, toString(refinement), before.string(),
                                 toString(beforeRefinement)));
}

/// Read the texture of a velocity's frame, which must have the velocity's transform or a refined one.
MeasuredTexture textureOf(const VelocityFrame& frame, const TextureFiles& files, const std::string& name)
{
    MeasuredTexture loaded = readTexture(files.path(frame.file.frame), name);
    loaded.refinement = refinementOf(frame, *loaded.transform, loaded.path, loaded.gridName);
    return loaded;
}

/// Read the texture after another one, which must have the same transform.
MeasuredTexture successorOf(const MeasuredTexture& before, const VelocityFrame& frame, const TextureFiles& files,
                            const std::string& name)
{
    MeasuredTexture loaded = textureOf(frame, files, name);
    if (loaded.refinement == before.refinement) return loaded;
    refuseRefinement(loaded.path, loaded.gridName, loaded.refinement, before.path, before.refinement);
}

/// A sparse texture read from a file.
struct ReadSparse {
    std::filesystem::path path;
    SparseTexture texture;
};

/// Read the sparse texture of a velocity's frame. @param before the one before it, or null
ReadSparse sparseTextureOf(const VelocityFrame& frame, const TextureFiles& files, const std::string& given,
                           const ReadSparse* before)
{
    const std::filesystem::path path = files.path(frame.file.frame);
    const VdbFile file = readVdb(path);
    if (!isSparse(file.metadata)) {
        throw InputError(fmt::format("{}: its texture is dense and that of the first file sparse; measure each kind "
                                     "by itself",
                                     path.string()));
    }
    const std::string name = textureName(file.metadata, given);
    const auto grid = file.get<openvdb::FloatGrid>(name, "`texture`");
    auto active = std::make_shared<openvdb::MaskTree>(grid->tree(), false, true, openvdb::TopologyCopy());
    active->voxelizeActiveTiles();
    ReadSparse read{
        path,
        {grid->treePtr(), std::make_shared<const Domain>(active), refinementOf(frame, grid->transform(), path, name)}};
    if (const auto spacing = file.metadata.getMetadata<openvdb::Vec3SMetadata>("spacing")) {
        const openvdb::Vec3s& given3 = spacing->value();
        if (given3[0] > 0 && given3[1] > 0 && given3[2] > 0) read.texture.spacing = {given3[0], given3[1], given3[2]};
    }
    if (before && read.texture.refinement != before->texture.refinement)
        refuseRefinement(path, name, read.texture.refinement, before->path, before->texture.refinement);
    return read;
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

void measureSparseSequence(const SequenceCoherenceParams& params, const TextureFiles& files, VelocitySequence& flow,
                           std::size_t total, Reporter& reporter, SequenceCoherence& result)
{
    reporter.say(sparseHeading());
    std::optional<VelocityFrame> current = flow.next(), next;
    std::optional<ReadSparse> texture, nextTexture;
    if (current) {
        texture = sparseTextureOf(*current, files, params.textureName, nullptr);
        result.refine = texture->texture.refinement.factors;
    }
    for (; current; current = std::move(next), texture = std::move(nextTexture)) {
        reporter.checkStop();
        next = flow.next();
        nextTexture = std::nullopt;
        if (next) nextTexture = sparseTextureOf(*next, files, params.textureName, &*texture);
        const VelocityFrame &start = *current, &end = next ? *next : start;
        const FrameInterval interval = flow.intervalAfter(*current, next ? &*next : nullptr);
        if (result.sparse.empty()) flow.describe(*current, interval, start.largestDisplacement(interval.seconds));
        const FlowStep step{start, end, interval.seconds};
        VelocityField forward, backward;
        forward.build(start.domain.velocity, step.startVelocities(), step.endVelocities());
        if (next) backward.build(end.domain.velocity, step.endVelocities() * -1.0, step.startVelocities() * -1.0);
        const SparseCoherence frame =
            measureSparse(texture->texture, nextTexture ? &nextTexture->texture : nullptr, forward,
                          next ? &backward : nullptr, params.coherence, start.file.frame);
        reporter.say(sparseLine(frame));
        if (frame.points == 0) {
            reporter.warn(fmt::format("frame {}: no streak that can be seen moves by a voxel of the texture a step; "
                                      "check unit and frame spacing",
                                      frame.frame));
        }
        result.sparse.push_back(frame);
        reporter.progress(result.sparse.size(), total);
    }
    for (std::size_t i = 0; i < kSparseFigures.size(); ++i) {
        std::vector<double> values;
        for (const SparseCoherence& frame : result.sparse)
            values.push_back(frame.figures.*kSparseFigures[i].value);
        result.sparseMeans[i] = estimateMean(values);
    }
    for (const std::string& line : sparseMeanLines(result))
        reporter.say(line);
}

} // namespace

SequenceCoherence coherenceOfSequence(const SequenceCoherenceParams& params, Reporter& reporter)
{
    params.validate();
    const TextureFiles files(params);
    checkFurtherOutput(params.json, params, files);
    std::istringstream noLines;
    OneProcess alone;
    std::size_t total = 0;
    VelocitySequenceParams seen = params.flow;
    seen.observer = files.observer();
    VelocitySequence flow(std::move(seen), openSequence(params.flow.input, noLines, total), reporter, alone);
    flow.setMotion(files.motion());

    SequenceCoherence result;
    if (files.areSparse()) {
        measureSparseSequence(params, files, flow, total, reporter, result);
        if (!params.json.empty() && writeReport(params.json, toJson(result, params))) reporter.finished(params.json);
        return result;
    }
    std::optional<VelocityFrame> current = flow.next(), next;
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
        const VelocityFrame& end = next ? *next : *current;
        const FrameInterval interval = flow.intervalAfter(*current, next ? &*next : nullptr);
        if (result.frames.empty()) flow.describe(*current, interval, current->largestDisplacement(interval.seconds));
        VelocityField field;
        const FlowStep step{*current, end, interval.seconds};
        field.build({texture->texture.sharedDomain(), current->domain.velocity, texture->refinement},
                    step.startVelocities(), step.endVelocities());
        FrameCoherence frame = measureCoherence(texture->texture, nextTexture ? &nextTexture->texture : nullptr, field,
                                                params.coherence, current->file.frame);
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
    return result;
}

} // namespace vdblic
