#include "vdblic/run/sequence_info.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/derived_grids.h"
#include "vdblic/flow/frame_interval.h"
#include "vdblic/flow/observed_frame.h"
#include "vdblic/flow/velocity_sequence_params.h"
#include "vdblic/io/checksum.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/io/vdb_header.h"
#include "vdblic/io/velocity_grids.h"
#include "vdblic/methods/memory_estimate.h"
#include "vdblic/methods/registry.h"
#include "vdblic/methods/streaks/streak_shape.h"
#include "vdblic/methods/streaks/streaks.h"
#include "vdblic/run/displacements.h"
#include "vdblic/run/sequence_advice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <string>
#include <type_traits>

namespace vdblic {
namespace {

using ValueGrids = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                                     openvdb::Vec3SGrid, openvdb::Vec3DGrid>;

/// Set the sequence's frames on disk, and the missing ones. @return the files
std::vector<FrameFile> findFiles(const SequenceParams& input, SequenceInfo& info)
{
    if (input.pattern == "-")
        throw ParameterError("paths on standard input cannot be inspected; name a file or a pattern");
    const FramePattern pattern(input.pattern);
    std::vector<FrameFile> files;
    if (!pattern.hasField()) {
        files = selectFrames(input);
        info.frames = {files.front().frame};
        info.isFrozen = true;
        return files;
    }
    const std::vector<std::int64_t> found = pattern.framesOnDisk();
    if (found.empty()) (void)selectFrames(input); // throws with the matching files
    std::vector<std::int64_t> wanted;
    if (input.frames.empty()) {
        const std::int64_t spacing = frameSpacing(input);
        for (std::int64_t frame = found.front(); frame <= found.back() && wanted.size() < kMaxFrames; frame += spacing)
            wanted.push_back(frame);
    } else {
        wanted = parseFrameList(input.frames);
    }
    std::set_difference(wanted.begin(), wanted.end(), found.begin(), found.end(), std::back_inserter(info.missing));
    info.frames = found;
    if (!input.frames.empty()) {
        info.frames.clear();
        std::set_intersection(wanted.begin(), wanted.end(), found.begin(), found.end(),
                              std::back_inserter(info.frames));
    }
    if (info.frames.empty())
        throw InputError(fmt::format("{}: no frame of {} is on disk", input.pattern, input.frames));
    info.isFrozen = found.size() == 1;
    for (const std::int64_t frame : info.frames)
        files.push_back({frame, pattern.path(frame)});
    return files;
}

void addHeader(const openvdb::GridBase& grid, SequenceInfo& info)
{
    const auto sameName = [&](const GridInfo& known) { return known.name == grid.getName(); };
    auto known = std::find_if(info.grids.begin(), info.grids.end(), sameName);
    if (known == info.grids.end()) {
        GridInfo first;
        first.name = grid.getName();
        first.type = grid.valueType() + (grid.saveFloatAsHalf() ? ", half on disk" : "");
        first.gridClass = openvdb::GridBase::gridClassToString(grid.getGridClass());
        first.leastVoxels = std::numeric_limits<std::uint64_t>::max();
        first.transform = grid.transform().copy();
        known = info.grids.insert(known, first);
    }
    const auto number = [&](const char* key) { // of a file: untrusted
        constexpr double kMost = 1e18;
        const double told = numericMetadata(grid, key).value_or(0);
        return told > 0 ? std::uint64_t(std::min(told, kMost)) : std::uint64_t(0);
    };
    const std::uint64_t voxels = number(openvdb::GridBase::META_FILE_VOXEL_COUNT);
    ++known->files;
    known->leastVoxels = std::min(known->leastVoxels, voxels);
    known->mostVoxels = std::max(known->mostVoxels, voxels);
    known->mostMemory = std::max(known->mostMemory, number(openvdb::GridBase::META_FILE_MEM_BYTES));
    known->box.expand(storedBox(grid).value_or(openvdb::CoordBBox()));
    known->transformChanges = known->transformChanges || *known->transform != grid.transform();
}

void addHeaders(const openvdb::GridPtrVec& grids, SequenceInfo& info)
{
    std::map<std::string, std::size_t> ofName;
    for (const openvdb::GridBase::Ptr& grid : grids) {
        if (++ofName[grid->getName()] == 1) addHeader(*grid, info);
    }
    for (GridInfo& grid : info.grids)
        grid.ofName = std::max(grid.ofName, ofName[grid.name]);
}

template<typename GridT>
void addValues(const GridT& grid, ValueInfo& info)
{
    for (auto value = grid.cbeginValueOn(); value; ++value) {
        double number = 0;
        if constexpr (std::is_arithmetic_v<typename GridT::ValueType>) {
            number = double(*value);
        } else {
            number = double(value->length());
        }
        if (std::isfinite(number)) {
            info.low = std::min(info.low, number);
            info.high = std::max(info.high, number);
        } else {
            info.notFinite += value.getVoxelCount();
        }
    }
}

void addValues(const VdbFile& file, SequenceInfo& info)
{
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    for (GridInfo& of : info.grids) {
        const auto grid = file.find<openvdb::GridBase>(of.name);
        if (!grid) continue;
        ValueInfo values = of.values.value_or(ValueInfo{kInfinity, -kInfinity});
        const bool known = grid->apply<ValueGrids>([&](const auto& typed) { addValues(typed, values); });
        if (known && (values.isFinite() || values.notFinite > 0)) of.values = values;
    }
}

/// The velocity according to the headers of a file; nothing if there is none. @param times of the frame
std::optional<VelocityInfo> velocityOf(const VdbFile& header, const VelocityParams& params, FrameTimes& times)
{
    std::vector<std::string> names = {params.grid};
    if (params.grid.empty()) names = velocityNames(header);
    if (names.empty()) names = vectorNames(header);
    if (names.empty()) return std::nullopt;
    const VelocityGrids grids = findVelocityGrids(header, names.front());
    VelocityInfo velocity;
    velocity.grid = grids.name;
    for (const openvdb::GridBase::Ptr& grid : grids.values)
        velocity.gridNames.push_back(grid->getName());
    const openvdb::GridBase& first = *grids.values.front();
    const VelocityConvention convention = conventionOf(first, params);
    velocity.unit = convention.unit;
    velocity.scale = convention.scale;
    times = timesOf(first, header.metadata);
    return velocity;
}

/// @param files, times of the first readable frames, at most two
void setInterval(const SequenceInfoParams& params, const std::vector<FrameFile>& files,
                 const std::vector<FrameTimes>& times, VelocityInfo& velocity)
{
    const bool isOne = files.size() < 2;
    const double skipped =
        isOne ? 1 : double(files[1].frame - files[0].frame) / double(frameSpacing(params.flow.input));
    auto interval = frameInterval(params.flow.frameSpacing, times[0], isOne ? nullptr : &times[1], skipped);
    if (!interval) {
        velocity.intervalFault = fmt::format("{}: its time {} does not come after the time {} of the frame before",
                                             files[1].path.string(), *times[1].time, *times[0].time);
        interval = frameInterval(params.flow.frameSpacing, {{}, times[0].dt}, nullptr, skipped);
    } else if (interval->isAssumed && times[0].dt) {
        velocity.intervalFault = fmt::format("{}: grid '{}' has the dt {}, which is no number of seconds",
                                             files[0].path.string(), velocity.grid, *times[0].dt);
    }
    velocity.interval = interval->seconds;
    velocity.intervalSource = interval->source;
    if (!velocity.intervalFault.empty())
        velocity.intervalSource += fmt::format(", because {}; give `frame_spacing`", velocity.intervalFault);
}

double meanLength(const openvdb::Vec3SGrid& grid, const openvdb::Mat3s& matrix)
{
    double sum = 0, count = 0;
    for (auto value = grid.cbeginValueOn(); value; ++value) {
        sum += double((matrix * *value).length()) * double(value.getVoxelCount());
        count += double(value.getVoxelCount());
    }
    return count > 0 ? sum / count : 0;
}

/// Add the displacements of a frame. @param frames added before  @param files total number
void addMotion(const FrameFile& file, const SequenceInfoParams& params, std::size_t frames, std::size_t files,
               Displacements& all, VelocityInfo& velocity)
{
    VelocityParams reading = params.flow.velocity;
    reading.nonFinite = NonFinite::kZero;
    reading.carry.clear();
    VelocityFrame frame = readVelocity(file, reading);
    if (!params.flow.observer.isAtRest()) {
        makePerSecond(frame, velocity.interval);
        ReferenceFrameParams observer = params.flow.observer;
        if (observer.followsMean) observer.velocity = meanVelocity(frame);
        observe(frame, std::make_shared<ReferenceFrame>(observer, frame.values->transform()), 0, std::nullopt);
    }
    if (!velocity.motion) velocity.motion.emplace();
    MotionInfo& motion = *velocity.motion;
    const double mean = meanLength(*frame.values, openvdb::Mat3s(frame.toVoxelsPerFrame(velocity.interval).matrix));
    motion.mean += (mean - motion.mean) / double(frames + 1);
    all.add(frame, velocity.interval);
    motion.fasterHalf = all.ofFasterHalf();
    if (frames == files / 2) motion.rotation = rotationShare(*frame.values, frame.toWorldPerSecond(velocity.interval));
    const double largest = frame.largestDisplacement(velocity.interval);
    if (largest < motion.largest && frames > 0) return;
    motion.largest = largest;
    motion.frame = file.frame;
    motion.otherUnits.clear();
    for (const VelocityUnit unit : {VelocityUnit::kWorldPerSecond, VelocityUnit::kWorldPerFrame,
                                    VelocityUnit::kVoxelPerSecond, VelocityUnit::kVoxelPerFrame}) {
        frame.unit = unit;
        Displacements other;
        other.add(frame, velocity.interval);
        const double moves = other.ofFasterHalf();
        if (unit != velocity.unit && makesStreaks(moves))
            motion.otherUnits.push_back(fmt::format("{}: {:.2g}", nameOf(unit), moves));
    }
}

/// Whether a grid is the velocity or one of its components.
bool isOf(const VelocityInfo& velocity, const GridInfo& grid)
{
    return std::find(velocity.gridNames.begin(), velocity.gridNames.end(), grid.name) != velocity.gridNames.end();
}

/// The cost of a run with default parameters otherwise. @param frames to compute
void estimateRun(const SequenceInfoParams& params, const SequenceInfo& info, std::size_t frames, VelocityInfo& velocity)
{
    double memory = 0;
    for (const GridInfo& grid : info.grids) {
        if (!isOf(velocity, grid)) continue;
        velocity.voxels = std::max(velocity.voxels, grid.mostVoxels);
        memory += double(grid.mostMemory);
    }
    // Voxels of whole leaves, at three floats each. Inactive ones lie at the rim; empty refined leaves are not stored.
    const double refine = params.refine.value_or(1), refined = refine * refine * refine;
    const double rim = std::max(0.0, memory / (3 * sizeof(float)) - double(velocity.voxels));
    const double ofTexture = refined * double(velocity.voxels) + refine * refine * rim;
    velocity.memory = denseBytes(ofTexture);
    velocity.seconds = denseSeconds(refined * double(velocity.voxels), double(frames));
    for (const TextureMethod* const method : textureMethods()) {
        const TextureMethod::Estimate* const estimate = method->estimate;
        if (!estimate) continue;
        const double bytes = estimate->bytes(ofTexture / refined, ofTexture);
        velocity.lookingBack.push_back({method->name, bytes, estimate->time * velocity.seconds});
    }
}

/// The cost of a run of streaks. @param frames to compute
void estimateStreaks(const SequenceInfoParams& params, const SequenceInfo& info, std::size_t frames,
                     VelocityInfo& velocity)
{
    constexpr double kSettling = 0.25; // frames of work to trace the first tails
    openvdb::CoordBBox box;
    double memory = 0;
    for (const GridInfo& grid : info.grids) {
        if (!isOf(velocity, grid)) continue;
        box.expand(grid.box);
        memory += double(grid.mostMemory);
    }
    if (velocity.voxels == 0 || box.empty()) return;
    const double moves = velocity.motion ? velocity.motion->fasterHalf : 0;
    StreakParams streaks;
    if (params.spacing) streaks.spacing.emplace().fill(float(*params.spacing));
    Refinement refinement;
    if (params.refine) {
        refinement.factors.fill(*params.refine);
        refinement.isGiven = true;
    }
    const StreakShape shape = streakShape(streaks, refinement, velocity.voxels, box, moves);
    const auto voxels = double(velocity.voxels);
    const double leaves = std::max(voxels, memory / (3 * sizeof(float))) / Domain::kLeafVoxels;
    const StreakCost cost = streakCost(shape, StreakForm::kVoxels, voxels, leaves, box);
    const StreakCost ofLines = streakCost(shape, StreakForm::kLines, voxels, leaves, box);
    const double traced = double(frames) + kSettling;
    velocity.streaks = {.spacing = shape.spacing,
                        .refine = shape.refinement.factors,
                        .memory = cost.bytes,
                        .seconds = traced * cost.secondsPerFrame,
                        .lineMemory = ofLines.bytes,
                        .lineSeconds = traced * ofLines.secondsPerFrame};
    if (moves > 0) velocity.streaks->tail = shape.tail;
}

} // namespace

Parameters parametersOf(SequenceInfoParams& params)
{
    const Parameters own = {
        parameter("frames", "Frames to look at: 1-100, 1-100x2 or 1,5,9-20; every one by default.",
                  params.flow.input.frames),
        parameter("values", "Read the voxels too: their range, those that are not finite, displacements, checksums.",
                  params.values),
        parameter("refine", "Refinement for the estimate of memory and time.", params.refine,
                  {.limits = {1, double(Refinement::kMost)}}),
        parameter("spacing", "Spacing of streaks for the estimate of memory and time.", params.spacing,
                  {.unit = "voxels of the velocity", .limits = {0.01, 1e6}}),
    };
    return joined({own, parametersOf(params.flow)});
}

void SequenceInfoParams::validate() const
{
    flow.validate();
}

SequenceInfo inspectSequence(const SequenceInfoParams& params, const Reporter& reporter)
{
    params.validate();
    SequenceInfo info;
    info.pattern = params.flow.input.pattern;
    const std::vector<FrameFile> files = findFiles(params.flow.input, info);
    std::vector<FrameTimes> times;
    std::vector<FrameFile> readable;
    for (const FrameFile& file : files) {
        reporter.checkStop();
        try {
            VdbHeader header = readVdbHeader(file.path);
            std::ifstream stream(file.path, std::ios::binary);
            const std::uintmax_t size = std::filesystem::file_size(file.path);
            info.bytes += size;
            info.withChecksums += hasChecksums(readLayout(stream, size)) ? 1 : 0;
            addHeaders(header.grids, info);
            const auto creator = header.metadata.getMetadata<openvdb::StringMetadata>("creator");
            if (creator && info.creator.empty()) info.creator = creator->value();
            FrameTimes ofFrame;
            auto velocity = velocityOf({header.grids, header.metadata, file.path}, params.flow.velocity, ofFrame);
            if (velocity && !info.velocity) info.velocity = std::move(velocity);
            if (times.size() < 2) times.push_back(ofFrame);
            readable.push_back(file);
        } catch (const InputError& error) {
            info.damaged.emplace_back(error.what());
        }
    }
    if (info.velocity) {
        setInterval(params, readable, times, *info.velocity);
        estimateRun(params, info, files.size(), *info.velocity);
    }
    Displacements displacements;
    for (std::size_t i = 0; params.values && i < readable.size(); ++i) {
        reporter.checkStop();
        try {
            addValues(readVdb(readable[i].path), info);
            if (info.velocity) addMotion(readable[i], params, i, readable.size(), displacements, *info.velocity);
        } catch (const InputError& error) {
            info.damaged.emplace_back(error.what());
        }
    }
    if (info.velocity) estimateStreaks(params, info, files.size(), *info.velocity);
    info.advice = adviceFor(info);
    return info;
}

} // namespace vdblic
