#include "vdblic/flow/velocity_sequence.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/printable.h"
#include "vdblic/core/stopwatch.h"
#include "vdblic/distributed/velocity_halo.h"
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
    const std::optional<FrameFile> file = mAhead.get();
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
VelocityFrame VelocitySequence::load(const FrameFile& file, const std::optional<VelocityPart>& part) const
{
    Stopwatch watch;
    const std::string stamp = stampOf(file); // before reading: a later change then differs from it
    VelocityFrame frame = readVelocity(file, mParams.velocity, part);
    frame.stamp = stamp;
    frame.sourceFrame = double(file.frame - file.repeats);
    frame.domain = mLastDomain;
    const openvdb::Vec3SGrid& values = *frame.values;
    const bool isSame = mLastDomain.texture && mParams.domain.mask.empty() &&
                        mLastValues->transform() == values.transform() &&
                        mLastValues->tree().hasSameTopology(values.tree());
    try {
        if (!isSame) {
            auto topology =
                file.contents && !mExchange.isAlone()
                    ? joinedTopology(values.tree(), mExchange)
                    : std::make_shared<openvdb::MaskTree>(values.tree(), false, true, openvdb::TopologyCopy());
            frame.domain = makeDomain(std::move(topology), values.transform(), mParams.domain,
                                      file.frame - file.repeats, mExchange.size());
        }
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: grid {}: {}", file.path.string(), frame.gridName, error.what()));
    }
    frame.readSeconds = watch.lap();
    return frame;
}

/// Read a frame's part. All ranks cut the first frame's domain alike.
VelocityFrame VelocitySequence::loadPart(const FrameFile& file) const
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
        const VoxelBox<Space::kVelocity> nowhere{{openvdb::Coord(1 << 28), openvdb::Coord(1 << 28)}};
        const VelocityFrame voxels = load(file, VelocityPart{nowhere, false});
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
