#include "vdblic/flow/flow_sequence.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/stopwatch.h"
#include "vdblic/flow/frame_halo.h"
#include "vdblic/io/file_stamp.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/vdb_file.h"

#include <fmt/format.h>

#include <cstdint>
#include <memory>
#include <utility>

namespace vdblic {
namespace {

std::string frameStamp(const FrameFile& file, const DomainParams& domain)
{
    std::string stamp = fmt::format("frame {}, {}", file.frame, file.contents ? "in memory" : fileStamp(file.path));
    if (domain.mask.empty()) return stamp;
    const FramePattern mask(parseGridReference(domain.mask).path.string());
    return fmt::format("{}, mask {}", stamp, fileStamp(mask.path(file.frame - file.repeats)));
}

/// @param ranks that share the frame  @param part whose values are needed
/// @param before the frame before; its domain, if it is given, is used again where the voxels are the same
LoadedFrame load(const FrameFile& file, const FlowSequenceParams& params, int ranks,
                 const std::optional<VelocityPart>& part, const FlowFrame& before)
{
    Stopwatch watch;
    LoadedFrame frame;
    frame.sourceFrame = double(file.frame - file.repeats);
    frame.stamp = frameStamp(file, params.domain); // before reading: a later change then differs from it
    frame.velocity = readVelocity(file, params.velocity, part);
    const openvdb::Vec3SGrid& values = *frame.velocity.values;
    const bool isSame = before.domain && params.domain.mask.empty() &&
                        before.velocities->transform() == values.transform() &&
                        before.velocities->tree().hasSameTopology(values.tree());
    try {
        frame.domain = before.fieldDomain();
        if (!isSame) {
            auto topology = std::make_shared<openvdb::MaskTree>(values.tree(), false, true, openvdb::TopologyCopy());
            frame.domain =
                makeDomain(std::move(topology), values.transform(), params.domain, file.frame - file.repeats, ranks);
        }
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: grid {}: {}", file.path.string(), frame.velocity.gridName, error.what()));
    }
    frame.seconds = watch.lap();
    return frame;
}

} // namespace

FlowSequence::FlowSequence(FlowSequenceParams params, FrameSource source, Reporter& reporter, const Exchange& exchange)
    : mParams(std::move(params)), mReporter(reporter), mExchange(exchange), mSource(std::move(source))
{
}

std::string FlowSequence::stampOf(const FrameFile& file) const
{
    return frameStamp(file, mParams.domain);
}

std::optional<LoadedFrame> FlowSequence::next()
{
    if (!mStarted) lookAhead(std::launch::deferred);
    if (!mAhead.valid()) return std::nullopt;
    const std::optional<FrameFile> file = mAhead.get();
    if (!file) return std::nullopt;
    LoadedFrame frame = loadPart(*file);
    if (!mPartition) mPartition = frame.partition;
    // Deferred, too, where no thread can be started.
    lookAhead(file->contents ? std::launch::deferred : std::launch::async | std::launch::deferred);
    checkSuccession(frame.velocity);
    mLast = frame.flow();
    if (!mExchange.isAlone())
        mLast.domain = mLast.refinedFrom = nullptr; // a rank's part: the next frame needs the whole
    for (const std::string& remark : frame.velocity.remarks)
        sayOnce(remark);
    return frame;
}

std::optional<LoadedFrame> FlowSequence::after()
{
    const std::optional<std::int64_t> number = framesAround(mParams.input).after;
    if (!number) return std::nullopt;
    try {
        LoadedFrame frame = loadPart({*number, FramePattern(mParams.input.pattern).path(*number)});
        checkSuccession(frame.velocity);
        return frame;
    } catch (const InputError& error) {
        mReporter.warn(fmt::format("{}; frame {} is not used: the flow after the last frame stays as it is",
                                   error.what(), *number));
        return std::nullopt;
    }
}

FrameInterval FlowSequence::intervalAfter(const LoadedFrame& current, const LoadedFrame* next)
{
    const VelocityFrame& velocity = current.velocity;
    // A frame spacing holds for neighbours on disk; over frames that are left out, more time passes.
    double skipped = 1;
    if (next) {
        const std::int64_t difference = next->velocity.file.frame - velocity.file.frame;
        if (mSpacing == 0) mSpacing = mParams.input.pattern == "-" ? difference : frameSpacing(mParams.input);
        if (difference > 0 && mSpacing > 0) skipped = double(difference) / double(mSpacing);
    }
    const bool isSame = next && next->velocity.file.repeats > 0; // of a field that stands still
    const FrameTimes* const end = next && !isSame ? &next->velocity : nullptr;
    const auto interval = frameInterval(mParams.frameSpacing, velocity, end, skipped);
    if (!interval) {
        throw InputError(fmt::format("{}: its time {} does not come after the time {} of the frame before; give the "
                                     "frame spacing with `frame_spacing`",
                                     next->velocity.file.path.string(), *next->velocity.time, *velocity.time));
    }
    if (interval->isAssumed) {
        sayOnce(velocity.dt
                    ? fmt::format("the dt of grid {} is {}, which is no time between frames: taking 24 frames a "
                                  "second; give `frame_spacing` if it is another",
                                  velocity.gridName, *velocity.dt)
                    : "no time or dt in the files: taking 24 frames a second; give `frame_spacing` if it is another");
    }
    return *interval;
}

void FlowSequence::describe(const LoadedFrame& frame, const FrameInterval& interval, double largest)
{
    const VelocityFrame& velocity = frame.velocity;
    const bool given = mParams.velocity.unit.has_value();
    mReporter.detail(
        fmt::format("velocity: grid {}; unit {} x {} ({}); {} s between frames ({}); at most {:.2f} voxels a step",
                    velocity.gridName, nameOf(velocity.unit), velocity.scale,
                    given                ? "as given"
                    : velocity.mantaflow ? "a Mantaflow cache"
                                         : "by default",
                    interval.seconds, interval.source, largest));
}

/// Read a frame's part. All ranks cut the first frame's domain in the same way.
LoadedFrame FlowSequence::loadPart(const FrameFile& file) const
{
    const int rank = mExchange.rank(), ranks = mExchange.size();
    if (mExchange.isAlone()) return load(file, mParams, ranks, std::nullopt, mLast);
    std::shared_ptr<const Partition> partition = mPartition;
    if (!partition) {
        const openvdb::CoordBBox nowhere(openvdb::Coord(1 << 28), openvdb::Coord(1 << 28));
        const LoadedFrame voxels = load(file, mParams, ranks, VelocityPart{nowhere, false}, mLast);
        partition = std::make_shared<const Partition>(*voxels.domain.velocity, voxels.domain.refinement.factors, ranks);
    }
    // Carried grids, which rank 0 writes, are whole. The ranks verify the files in turn.
    std::optional<VelocityPart> part;
    if (rank > 0 || mParams.velocity.carry.empty())
        part = {partition->box(rank), std::uint64_t(file.frame) % std::uint64_t(ranks) == std::uint64_t(rank)};
    LoadedFrame frame = load(file, mParams, ranks, part, mLast);
    frame.partition = std::move(partition);
    keepOwn(frame, rank);
    return frame;
}

void FlowSequence::lookAhead(std::launch how)
{
    mStarted = true;
    mAhead = std::async(how, [this] {
        std::optional<FrameFile> file = mSource();
        if (file && !file->contents) cacheFile(file->path);
        return file;
    });
}

void FlowSequence::checkSuccession(const VelocityFrame& velocity) const
{
    if (!mLast.velocities || mLast.velocities->transform() == velocity.values->transform()) return;
    throw InputError(fmt::format("{}: grid {}: the transform differs from that of the frame before; {}",
                                 velocity.file.path.string(), velocity.gridName,
                                 velocity.mantaflow ? "switch off the adaptive domain in Blender and bake again"
                                                    : "resample the sequence onto one grid"));
}

void FlowSequence::sayOnce(const std::string& message)
{
    if (mSaid.insert(message).second) mReporter.say(message);
}

} // namespace vdblic
