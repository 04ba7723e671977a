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

/// The checkpoint of a run: read at the start, written between steps, removed at the end (docs/advect.md).
/// Not thread-safe.
class RunCheckpoint {
  public:
    /// All arguments must outlive this. @throws ParameterError
    /// @param exchange with the ranks that share the run; find(), write() and remove() are collective
    RunCheckpoint(const AdvectPlan& plan, RunOutputs& outputs, Reporter& reporter, Exchange& exchange);

    // To resume an interrupted run, in the order of the calls:

    /// Read the checkpoint, if it exists and the parameters ask for it.
    /// @throws InputError; ParameterError, also if it exists and the parameters neither resume nor restart
    [[nodiscard]] std::optional<Checkpoint> find();

    /// Skip the frames that the interrupted run finished. @return their outputs
    /// @throws InputError if an input or output of them is missing or differs
    [[nodiscard]] std::vector<std::filesystem::path> passOver(const Checkpoint& checkpoint, VelocitySequence& flow);

    /// Check that the sequence may end with a frame. @throws InputError if textures of later frames are finished
    void checkEnds(const Checkpoint& checkpoint, const FrameFile& last) const;

    /// Restore the interrupted run's state into a new texture.
    /// @param frame   from or after which the next step starts
    /// @param outputs of passOver(); receives the finished substeps of the frame
    /// @throws InputError
    void restore(const Checkpoint& checkpoint, const VelocityFrame& frame, FlowTexture& texture,
                 std::vector<std::filesystem::path>& outputs) const;

    // During the run:

    /// Record the stamp of a frame that was read. @throws InputError if it differs from the interrupted run's
    void noteInput(const std::filesystem::path& path, const std::string& stamp);

    /// Called when a step begins; if it fails midway there is no state to resume from.
    void stepBegins() { mUnsaved.reset(); }
    /// Called when a step is done. @param frame from which the next step starts
    void stepDone(const RunPosition& position, const VelocityFrame& frame);

    [[nodiscard]] bool isDue() const { return mSchedule.isDue(); }
    /// Whether checkpoints are wanted and the current state is in none.
    [[nodiscard]] bool isUnsaved() const { return mUnsaved && mSchedule.enabled(); }

    /// Write a checkpoint of the last step, whose outputs must be on disk. @throws InputError, OutputError
    void write(const FlowTexture& texture);

    /// Remove the checkpoint, if any. @throws OutputError
    void remove() const;

  private:
    /// A state in no checkpoint.
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
    std::vector<std::string> mInputs, mExpected; // stamps of the frames read by this run, and by the interrupted one
    std::optional<Unsaved> mUnsaved;
};

} // namespace vdblic
