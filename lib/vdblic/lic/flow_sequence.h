#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/field/domain_mask.h"
#include "vdblic/field/velocity_frame.h"
#include "vdblic/io/sequence.h"
#include "vdblic/lic/flow_texture.h"

#include <future>
#include <iosfwd>
#include <optional>
#include <set>
#include <string>

namespace vdblic {

/// A velocity sequence and how to understand it.
struct FlowSequenceParams {
    SequenceParams input;
    VelocityParams velocity;
    std::optional<double> frameSpacing; ///< seconds between frames on disk; nothing: by metadata, else 1/24
    DomainParams domain;

    void validate() const; ///< @throws ParameterError
};

/// A frame that was read, with the domain it is computed on.
struct LoadedFrame {
    double seconds = 0; ///< that reading took
    VelocityFrame velocity;
    FlowFrame flow;
    std::string stamp; ///< FlowSequence::stampOf() when it was read
};

/// Time between two frames, and where it was taken from.
struct FrameInterval {
    double seconds;
    const char* source;
};

/// Reads a velocity sequence frame by frame, one ahead of the one that is asked for.
///
/// Choices made for the user are said to the reporter, each once.
class FlowSequence {
  public:
    /// @param lines source of the paths if the input is `-`
    /// @throws InputError, ParameterError
    FlowSequence(FlowSequenceParams params, std::istream& lines, Reporter& reporter);

    /// The number of frames; 0 if it is not known.
    [[nodiscard]] std::size_t total() const { return mTotal; }

    /// Pass over a frame without reading it, or nothing at the end. Only before the first call of next().
    std::optional<FrameFile> skip() { return mSource(); }

    /// What tells whether a frame or one of its files was changed: its number, and the stamps of input and mask.
    [[nodiscard]] std::string stampOf(const FrameFile& file) const;

    /// The next frame, or nothing at the end.
    /// @throws InputError if it cannot be read or its transform is not that of the frame before
    std::optional<LoadedFrame> next();

    /// @param next the frame after it, or null. @throws InputError if the files' times do not ascend
    FrameInterval intervalAfter(const LoadedFrame& current, const LoadedFrame* next);

    /// The spacing of the frame numbers on disk, to be handed to a run that goes on where this one is; 0 until known.
    [[nodiscard]] std::int64_t spacing() const { return mSpacing; }
    void setSpacing(std::int64_t spacing) { mSpacing = spacing; }

    /// Give the details of what was found in a frame.
    void describe(const LoadedFrame& frame, const FrameInterval& interval);

  private:
    void readAhead();
    void checkSuccession(const VelocityFrame& velocity) const;
    void sayOnce(const std::string& message);

    FlowSequenceParams mParams;
    Reporter& mReporter;
    std::size_t mTotal = 0;
    FrameSource mSource;
    openvdb::Vec3SGrid::ConstPtr mLast; // the velocity of the frame before
    std::int64_t mSpacing = 0;          // of the frame numbers on disk; 0 until known
    std::set<std::string> mSaid;
    bool mStarted = false;
    std::future<std::optional<LoadedFrame>> mAhead; // last: it uses the others
};

} // namespace vdblic
