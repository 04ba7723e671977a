#include "vdblic/flow/velocity_sequence.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/printable.h"
#include "vdblic/core/stopwatch.h"
#include "vdblic/distributed/velocity_halo.h"
#include "vdblic/flow/frame_halo.h"
#include "vdblic/flow/observed_frame.h"
#include "vdblic/io/file_stamp.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/vdb_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

std::string frameStamp(const FrameFile& file, const DomainParams& domain)
{
    std::string stamp = fmt::format("frame {}, {}", file.frame, file.contents ? "in memory" : fileStamp(file.path));
    if (domain.mask.empty()) return stamp;
    const FramePattern mask(parseGridReference(domain.mask).path.string());
    return fmt::format("{}, mask {}", stamp, fileStamp(mask.path(file.frame - file.repeats)));
}

/// The reason why a frame's metadata do not give the time to the next frame.
std::string missingTime(const VelocityFrame& frame)
{
    const openvdb::MetaMap& metadata = *frame.values;
    const openvdb::Metadata::ConstPtr dt = metadata["dt"], time = metadata["time"];
    const auto said = [&](const char* key, const std::string& value) {
        return fmt::format("{}: grid '{}' has the {} {:.60}, which is no number of seconds", frame.file.path.string(),
                           frame.gridName, key, value);
    };
    if (frame.dt) return said("dt", dt ? printable(dt->str()) : fmt::format("{}", *frame.dt));
    if (time && !frame.time) return said("time", printable(time->str()));
    return "no time or dt in the files";
}

/// No leaf: a frame's times and active voxels.
const VelocityPart kNoValues{{{openvdb::Coord(1 << 28), openvdb::Coord(1 << 28)}}, false};

bool isPerFrame(VelocityUnit unit)
{
    return unit == VelocityUnit::kWorldPerFrame || unit == VelocityUnit::kVoxelPerFrame;
}

} // namespace

VelocitySequence::VelocitySequence(VelocitySequenceParams params, FrameSource source, Reporter& reporter,
                                   Exchange& exchange)
    : mParams(std::move(params)), mReporter(reporter), mExchange(exchange), mSource(std::move(source))
{
}

std::string VelocitySequence::stampOf(const FrameFile& file) const
{
    return frameStamp(file, mParams.domain);
}

std::optional<VelocityFrame> VelocitySequence::next()
{
    if (!mStarted) lookAhead(std::launch::deferred);
    if (!mAhead.valid()) return std::nullopt;
    const std::optional<FrameFile> file = noted(mAhead.get());
    if (!file) return std::nullopt;
    VelocityFrame frame = loadPart(*file);
    if (!mPartition) mPartition = frame.partition;
    // Deferred if no thread can be started.
    lookAhead(file->contents ? std::launch::deferred : std::launch::async | std::launch::deferred);
    checkSuccession(frame);
    mLastValues = frame.values;
    if (mExchange.isAlone()) mLastDomain = frame.domain;
    for (const std::string& remark : frame.remarks)
        sayOnce(remark);
    return frame;
}

std::optional<VelocityFrame> VelocitySequence::after()
{
    const std::optional<std::int64_t> number = framesAround(mParams.input).after;
    if (!number) return std::nullopt;
    try {
        VelocityFrame frame = loadPart({*number, FramePattern(mParams.input.pattern).path(*number)});
        checkSuccession(frame);
        return frame;
    } catch (const InputError& error) {
        mReporter.warn(fmt::format("{}; frame {} is not used: the flow after the last frame stays as it is",
                                   error.what(), *number));
        return std::nullopt;
    }
}

FrameInterval VelocitySequence::intervalAfter(const VelocityFrame& current, const VelocityFrame* next)
{
    // A frame spacing holds for neighbours on disk: skipped frames add to the time.
    double skipped = 1;
    if (next) {
        const std::int64_t difference = next->file.frame - current.file.frame;
        if (mSpacing == 0) mSpacing = mParams.input.pattern == "-" ? difference : frameSpacing(mParams.input);
        if (difference > 0 && mSpacing > 0) skipped = double(difference) / double(mSpacing);
    }
    const bool isSame = next && next->file.repeats > 0; // a steady field
    const FrameTimes* const end = next && !isSame ? next : nullptr;
    const auto interval = frameInterval(mParams.frameSpacing, current, end, skipped);
    if (!interval) {
        throw InputError(fmt::format("{}: its time {} does not come after the time {} of the frame before; give the "
                                     "frame spacing with `frame_spacing`",
                                     next->file.path.string(), *next->time, *current.time));
    }
    if (end && next->observer) checkObserved(current, *next, interval->seconds);
    if (interval->isAssumed && !std::exchange(mSaidInterval, true)) {
        mReporter.say(
            fmt::format("{}: taking 24 frames a second; give `frame_spacing` if it is another", missingTime(current)));
    }
    return *interval;
}

void VelocitySequence::describe(const VelocityFrame& frame, const FrameInterval& interval, double largest)
{
    const bool given = mParams.velocity.unit.has_value();
    mReporter.detail(
        fmt::format("velocity: grid {}; unit {} x {} ({}); {} s between frames ({}); at most {:.2f} voxels a step",
                    frame.gridName, nameOf(frame.unit), frame.scale,
                    given             ? "as given"
                    : frame.mantaflow ? "a Mantaflow cache"
                                      : "by default",
                    interval.seconds, interval.source, largest));
}

/// @param part to read
VelocityFrame VelocitySequence::load(const FrameFile& file, const std::optional<VelocityPart>& part)
{
    Stopwatch watch;
    const std::string stamp = stampOf(file); // before reading: a later change then differs from it
    VelocityFrame frame = read(file, part);
    frame.stamp = stamp;
    frame.sourceFrame = double(file.frame - file.repeats);
    frame.domain = mLastDomain;
    const openvdb::Vec3SGrid& values = *frame.values;
    const bool isPlaced = frame.observer && mParams.domain.worldBox; // at another place of the observer's space
    const bool isSame = mLastDomain.texture && mParams.domain.mask.empty() && !isPlaced &&
                        mLastValues->transform() == values.transform() &&
                        mLastValues->tree().hasSameTopology(values.tree());
    try {
        if (!isSame) {
            auto topology =
                file.contents && !mExchange.isAlone()
                    ? joinedTopology(values.tree(), mExchange)
                    : std::make_shared<openvdb::MaskTree>(values.tree(), false, true, openvdb::TopologyCopy());
            const openvdb::math::Transform::ConstPtr inWorld = frame.inWorld(values.transform());
            frame.domain =
                makeDomain(std::move(topology), *inWorld, mParams.domain, file.frame - file.repeats, mExchange.size());
        }
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: grid {}: {}", file.path.string(), frame.gridName, error.what()));
    }
    frame.readSeconds = watch.lap();
    return frame;
}

/// Read a velocity, as the observer sees it. @param part of the observer's voxels
VelocityFrame VelocitySequence::read(const FrameFile& file, const std::optional<VelocityPart>& part)
{
    if (mParams.observer.isAtRest()) return readVelocity(file, mParams.velocity, part);
    if (!mObserver) findObserver();
    std::optional<VelocityPart> stored = part;
    if (part) {
        const bool inFile = !mParams.frameSpacing;
        const FrameTimes times = inFile ? readVelocity(file, mParams.velocity, kNoValues) : FrameTimes{};
        stored = partSeen(*part, *mObserver, secondsSinceStart(file, times));
    }
    VelocityFrame frame = readVelocity(file, mParams.velocity, stored);
    makePerSecond(frame, mStartInterval);
    observe(frame, mObserver, secondsSinceStart(file, frame), part);
    return frame;
}

/// Note the first frame of the source, where an observer may start, and the spacing to the second.
std::optional<FrameFile> VelocitySequence::noted(std::optional<FrameFile> file)
{
    if (!file || mParams.observer.isAtRest()) return file;
    if (!mStart) {
        mStart = file;
    } else if (mStartSpacing == 0) {
        mStartSpacing = file->frame - mStart->frame;
    }
    return file;
}

/// Find where and when the observer starts, and the velocity if it is the mean. Collective.
void VelocitySequence::findObserver()
{
    FrameFile file = mStart.value();
    if (file.contents && (!mExchange.isAlone() || file.frame != 1)) {
        throw ParameterError("`frame_velocity`, `frame_rotation`: of frames in memory an observer needs all, from the "
                             "first on, in one process; take files");
    }
    if (!file.contents && mParams.input.pattern != "-") {
        const FramePattern pattern(mParams.input.pattern);
        if (pattern.hasField()) file.frame = pattern.framesOnDisk().front();
        file.path = pattern.path(file.frame);
        mStartSpacing = frameSpacing(mParams.input);
    }
    VelocityParams reading = mParams.velocity;
    reading.carry.clear();
    const bool isMean = mParams.observer.followsMean, readsValues = isMean && mExchange.isFirst();
    mStart = {file.frame, file.path}; // not to hold what is in memory
    VelocityFrame start = readVelocity(file, reading, readsValues ? std::nullopt : std::optional(kNoValues));
    mStartTimes = start;
    const FrameInterval interval = frameInterval(mParams.frameSpacing, start, nullptr, 1).value();
    const bool needsInterval = !start.time || isPerFrame(start.unit) || mParams.input.steadyFrames > 1;
    if (interval.isAssumed && needsInterval) {
        throw InputError(fmt::format("{}: {}, which an observer who moves needs: give `frame_spacing`",
                                     file.path.string(), start.time ? "no dt in the file" : missingTime(start)));
    }
    mStartInterval = interval.seconds;
    makePerSecond(start, mStartInterval);
    ReferenceFrameParams params = mParams.observer;
    if (isMean) {
        const std::array<double, 3> mean = readsValues ? meanVelocity(start) : std::array<double, 3>{};
        params.velocity.emplace();
        const std::vector<double> ofFirst = mExchange.join(std::vector<double>(mean.begin(), mean.end()));
        std::copy_n(ofFirst.begin(), mean.size(), params.velocity->begin());
        sayOnce(fmt::format("the observer moves at the mean velocity of frame {}: `frame_velocity` {}", file.frame,
                            fmt::join(*params.velocity, " ")));
    }
    mObserver = std::make_shared<const ReferenceFrame>(params, start.values->transform());
}

/// The time of a frame, counted from the observer's start.
double VelocitySequence::secondsSinceStart(const FrameFile& file, const FrameTimes& times) const
{
    const bool byTimes = !mParams.frameSpacing && file.repeats == 0 && times.time && mStartTimes.time;
    if (byTimes) return *times.time - *mStartTimes.time;
    const auto spacing = double(std::max<std::int64_t>(mStartSpacing, 1));
    return double(file.frame - mStart->frame) / spacing * mStartInterval;
}

/// Check that the observer moves as long as the flow does.
void VelocitySequence::checkObserved(const VelocityFrame& current, const VelocityFrame& next, double interval) const
{
    constexpr double kTolerance = 1e-4;
    const double seconds = next.observedSeconds - current.observedSeconds;
    if (std::abs(seconds - interval) <= kTolerance * interval) return;
    throw InputError(fmt::format("{}: frames {} and {} are {:.6g} s apart, but {:.6g} s by the times since frame {}, "
                                 "by which the observer moves: give `frame_spacing`",
                                 next.file.path.string(), current.file.frame, next.file.frame, interval, seconds,
                                 mStart->frame));
}

/// Read a frame's part. All ranks cut the first frame's domain alike.
VelocityFrame VelocitySequence::loadPart(const FrameFile& file)
{
    const int rank = mExchange.rank(), ranks = mExchange.size();
    if (mExchange.isAlone()) return load(file, std::nullopt);
    std::shared_ptr<const Partition> partition = mPartition;
    if (file.contents) {
        VelocityFrame frame = load(file, std::nullopt);
        const FrameDomain& domain = frame.domain;
        if (!partition)
            partition = std::make_shared<const Partition>(*domain.velocity, domain.refinement.factors, ranks);
        gatherParts(frame.values->tree(), mExchange, *partition);
        frame.partition = std::move(partition);
        keepOwn(frame, rank);
        return frame;
    }
    if (!partition) {
        const VelocityFrame voxels = load(file, kNoValues);
        partition = std::make_shared<const Partition>(*voxels.domain.velocity, voxels.domain.refinement.factors, ranks);
    }
    // Carried grids, which rank 0 writes, are whole. The ranks verify the files in turn.
    std::optional<VelocityPart> part;
    if (rank > 0 || mParams.velocity.carry.empty())
        part = {partition->box(rank), std::uint64_t(file.frame) % std::uint64_t(ranks) == std::uint64_t(rank)};
    VelocityFrame frame = load(file, part);
    frame.partition = std::move(partition);
    keepOwn(frame, rank);
    return frame;
}

void VelocitySequence::lookAhead(std::launch how)
{
    mStarted = true;
    mAhead = std::async(how, [this] {
        std::optional<FrameFile> file = mSource();
        if (file && !file->contents) cacheFile(file->path);
        return file;
    });
}

void VelocitySequence::checkSuccession(const VelocityFrame& velocity)
{
    const Domain& domain = *velocity.domain.velocity;
    if (!mPeriod && domain.voxelCount() > 0) mPeriod = domain.period();
    if (domain.voxelCount() > 0 && domain.period() != *mPeriod) {
        throw InputError(fmt::format("{}: grid {}: the active voxels end elsewhere than in the frames before, which a "
                                     "`periodic` box cannot: fill it, or give it with `box`",
                                     velocity.file.path.string(), velocity.gridName));
    }
    if (!mLastValues || mLastValues->transform() == velocity.values->transform()) return;
    throw InputError(fmt::format("{}: grid {}: the transform differs from that of the frame before; {}",
                                 velocity.file.path.string(), velocity.gridName,
                                 velocity.mantaflow ? "switch off the adaptive domain in Blender and bake again"
                                                    : "resample the sequence onto one grid"));
}

void VelocitySequence::sayOnce(const std::string& message)
{
    if (mSaid.insert(message).second) mReporter.say(message);
}

} // namespace vdblic
