#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/distributed/partition.h"
#include "vdblic/field/frame_domain.h"
#include "vdblic/flow/frame_interval.h"
#include "vdblic/flow/velocity_frame.h"
#include "vdblic/flow/velocity_sequence_params.h"
#include "vdblic/io/sequence.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace vdblic {

/// Reads a velocity sequence frame by frame. While a frame is used, a thread waits for the name of the next one's file,
/// and the system reads that file into its cache: a frame read ahead would take the memory of one more velocity. Frames
/// in memory are asked for as they are needed, in the caller's thread; of several ranks each gives a part of them.
///
/// Choices made for the user go to the reporter, each once. Not thread-safe.
class VelocitySequence {
  public:
    /// @param source   of the frames
    /// @param exchange with the ranks that share the run: each gets its part of every frame; next() is collective
    VelocitySequence(VelocitySequenceParams params, FrameSource source, Reporter& reporter, Exchange& exchange);

    /// Pass over a frame without reading it. Only before the first call of next().
    /// @return its file, or nothing at the end
    std::optional<FrameFile> skip() { return mSource(); }

    /// A text that changes whenever the frame or one of its files does: its number, and the stamps of input and mask.
    [[nodiscard]] std::string stampOf(const FrameFile& file) const;

    /// The next frame, or nothing at the end.
    /// @throws InputError if it cannot be read or its transform is not that of the frame before
    std::optional<VelocityFrame> next();

    /// The frame on disk after the last one that `input.frames` selects: the flow after the last frame leads to it.
    /// @return nothing if there is none, or it cannot be read, with a warning
    std::optional<VelocityFrame> after();

    /// The time from a frame to the next. @param next the frame after it, or null
    /// @throws InputError if the files' times do not ascend
    FrameInterval intervalAfter(const VelocityFrame& current, const VelocityFrame* next);

    /// The spacing of the frame numbers on disk, 0 until known; a run that goes on where this one is needs it.
    [[nodiscard]] std::int64_t spacing() const { return mSpacing; }
    void setSpacing(std::int64_t spacing) { mSpacing = spacing; }

    /// Scale the displacements of the frames to come (VelocityParams::motion).
    void setMotion(double motion) { mParams.velocity.motion = motion; }

    /// Give the ranks their parts of the frames to come by another partition.
    void cutAs(std::shared_ptr<const Partition> partition) { mPartition = std::move(partition); }

    /// Report how the velocity of a frame is understood. @param largest displacement in a step [voxels]
    void describe(const VelocityFrame& frame, const FrameInterval& interval, double largest);

  private:
    [[nodiscard]] VelocityFrame load(const FrameFile& file, const std::optional<VelocityPart>& part) const;
    [[nodiscard]] VelocityFrame loadPart(const FrameFile& file) const;
    void lookAhead(std::launch how);
    void checkSuccession(const VelocityFrame& velocity) const;
    void sayOnce(const std::string& message);

    VelocitySequenceParams mParams;
    Reporter& mReporter;
    Exchange& mExchange;
    std::shared_ptr<const Partition> mPartition; // null before the first frame
    FrameSource mSource;
    // Of the previous frame; without its domain if that is a rank's part: the next frame needs the whole.
    openvdb::Vec3SGrid::ConstPtr mLastValues;
    FrameDomain mLastDomain;
    std::int64_t mSpacing = 0; // of the frame numbers on disk; 0 until known
    std::set<std::string> mSaid;
    bool mStarted = false, mSaidInterval = false;
    std::future<std::optional<FrameFile>> mAhead; // the next file; last member: its thread uses the others
};

} // namespace vdblic
