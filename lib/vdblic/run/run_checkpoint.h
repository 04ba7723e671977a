#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/run/checkpoint.h"
#include "vdblic/run/checkpoint_schedule.h"
#include "vdblic/run/parameter_texts.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {

struct AdvectPlan;
class VelocitySequence;
class FlowTexture;
struct FrameFile;
struct VelocityFrame;
class RunOutputs;

/// The checkpoint of a run: taken up at the start, written between steps, removed at the end (docs/advect.md).
/// Not thread-safe.
class RunCheckpoint {
  public:
    /// All arguments must outlive this. @throws ParameterError
    /// @param exchange with the ranks that share the run; find(), write() and remove() are collective
    RunCheckpoint(const AdvectPlan& plan, RunOutputs& outputs, Reporter& reporter, Exchange& exchange);

    // Going on from the checkpoint of an interrupted run, in the order of the calls.

    /// Read it, if the parameters ask for that and there is one.
    /// @throws InputError; ParameterError, also if there is one and the parameters say nothing about it
    [[nodiscard]] std::optional<Checkpoint> find();

    /// Pass over the frames that the interrupted run finished. @return their outputs
    /// @throws InputError if one of them, input or output, is missing or differs
    [[nodiscard]] std::vector<std::filesystem::path> passOver(const Checkpoint& checkpoint, VelocitySequence& flow);

    /// Check that the sequence may end with a frame. @throws InputError if textures after that frame are finished
    void checkEnds(const Checkpoint& checkpoint, const FrameFile& last) const;

    /// Put the state of the interrupted run into a new one.
    /// @param frame   that the next step starts from or after
    /// @param outputs of passOver(); receives the finished substeps of the frame
    /// @throws InputError
    void restore(const Checkpoint& checkpoint, const VelocityFrame& frame, FlowTexture& texture,
                 std::vector<std::filesystem::path>& outputs) const;

    // Running.

    /// Record the stamp of a frame that was read. @throws InputError if the interrupted run read another
    void noteInput(const std::filesystem::path& path, const std::string& stamp);

    /// A step begins; if it fails midway there is no state to go on from.
    void stepBegins() { mUnsaved.reset(); }
    /// A step is made. @param frame that the next step starts from
    void stepDone(const RunPosition& position, const VelocityFrame& frame);

    [[nodiscard]] bool isDue() const { return mSchedule.isDue(); }
    /// Whether there is a state to go on from that no checkpoint holds, and checkpoints are wanted.
    [[nodiscard]] bool isUnsaved() const { return mUnsaved && mSchedule.enabled(); }

    /// Write a checkpoint of the last step; outputs up to there must be on disk. @throws InputError, OutputError
    void write(const FlowTexture& texture);

    /// Remove it, if there is one. @throws OutputError
    void remove() const;

  private:
    /// A state that no checkpoint holds.
    struct Unsaved {
        RunPosition position;
        openvdb::math::Transform::Ptr transform; // of the grids in the checkpoint
    };

    [[noreturn]] void refuseForeign() const;
    [[nodiscard]] VdbFile readPart(const Checkpoint& checkpoint, const CheckpointPart& part) const;
    void writeParts(const FlowTexture& texture, const Unsaved& unsaved, Checkpoint checkpoint);
    void removeParts(std::optional<std::uint64_t> but) const;
    void addFinished(const FrameFile& file, int substeps, std::vector<std::filesystem::path>& outputs) const;

    const AdvectPlan& mPlan;
    RunOutputs& mOutputs;
    Reporter& mReporter;
    Exchange& mExchange;
    ParameterTexts mParameters;
    CheckpointSchedule mSchedule;
    std::vector<std::string> mInputs, mExpected; // stamps of the frames read by this run and by the interrupted one
    std::optional<Unsaved> mUnsaved;
};

} // namespace vdblic
