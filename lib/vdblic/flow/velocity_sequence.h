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

/// Reads a velocity sequence frame by frame. While a frame is used, a thread waits for the name of the next file, which
/// the system then reads into its cache: reading the frame itself would take the memory of another velocity. Frames in
/// memory are requested on demand in the caller's thread; with several ranks each supplies a part.
///
/// A moving observer (VelocitySequenceParams::observer) gets frames in its own space; all times count from the first
/// frame on disk, or of standard input or memory, whichever frames are selected.
///
/// Choices made for the user are reported once. Not thread-safe.
class VelocitySequence {
  public:
    /// @param source   of the frames
    /// @param exchange with the ranks that share the run: each gets its part of every frame; next() is collective
    VelocitySequence(VelocitySequenceParams params, FrameSource source, Reporter& reporter, Exchange& exchange);

    /// Skip a frame without reading it. Only before the first call of next().
    /// @return its file, or nothing at the end
    std::optional<FrameFile> skip() { return noted(mSource()); }

    /// A text that changes whenever the frame or its files change: its number, and the stamps of input and mask.
    [[nodiscard]] std::string stampOf(const FrameFile& file) const;

    /// The next frame, or nothing at the end.
    /// @throws InputError if it cannot be read or its transform is not that of the frame before
    std::optional<VelocityFrame> next();

    /// The frame on disk after the last selected one (`input.frames`): the last flow leads to it.
    /// @return nothing if there is none, or with a warning if it cannot be read
    std::optional<VelocityFrame> after();

    /// The time from a frame to the next. @param next the frame after it, or null
    /// @throws InputError if the files' times do not ascend, or are not those by which an observer moved
    FrameInterval intervalAfter(const VelocityFrame& current, const VelocityFrame* next);

    /// The spacing of the frame numbers on disk, 0 until known; a resumed run needs it.
    [[nodiscard]] std::int64_t spacing() const { return mSpacing; }
    void setSpacing(std::int64_t spacing) { mSpacing = spacing; }

    /// Scale the displacements of later frames (VelocityParams::motion).
    void setMotion(double motion) { mParams.velocity.motion = motion; }

    /// Partition later frames differently.
    void cutAs(std::shared_ptr<const Partition> partition) { mPartition = std::move(partition); }

    /// Report the interpretation of a frame's velocity. @param largest displacement in a step [voxels]
    void describe(const VelocityFrame& frame, const FrameInterval& interval, double largest);

  private:
    [[nodiscard]] VelocityFrame load(const FrameFile& file, const std::optional<VelocityPart>& part);
    [[nodiscard]] VelocityFrame loadPart(const FrameFile& file);
    [[nodiscard]] VelocityFrame read(const FrameFile& file, const std::optional<VelocityPart>& part);
    [[nodiscard]] std::optional<FrameFile> noted(std::optional<FrameFile> file);
    void findObserver();
    [[nodiscard]] double secondsSinceStart(const FrameFile& file, const FrameTimes& times) const;
    void checkObserved(const VelocityFrame& current, const VelocityFrame& next, double interval) const;
    void lookAhead(std::launch how);
    void checkSuccession(const VelocityFrame& velocity);
    void sayOnce(const std::string& message);

    VelocitySequenceParams mParams;
    Reporter& mReporter;
    Exchange& mExchange;
    std::shared_ptr<const Partition> mPartition; // null before the first frame
    FrameSource mSource;
    // Of the previous frame; without its domain if that is a rank's part: the next frame needs the whole.
    openvdb::Vec3SGrid::ConstPtr mLastValues;
    FrameDomain mLastDomain;
    std::optional<Period> mPeriod;                   // of all frames with voxels
    std::int64_t mSpacing = 0;                       // of the frame numbers on disk; 0 until known
    std::shared_ptr<const ReferenceFrame> mObserver; // null at rest, and before the first frame
    std::optional<FrameFile> mStart;                 // of a moving observer; the source's first until mObserver is set
    FrameTimes mStartTimes;                          // of that frame
    std::int64_t mStartSpacing = 0;                  // of the frame numbers from there on; 0 until known
    double mStartInterval = 0;                       // seconds to the next frame, by that frame
    std::set<std::string> mSaid;
    bool mStarted = false, mSaidInterval = false;
    std::future<std::optional<FrameFile>> mAhead; // the next file; last member: its thread uses the others
};

} // namespace vdblic
