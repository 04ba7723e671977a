#pragma once

#include "vdblic/io/vdb_file.h"
#include "vdblic/lic/advect_params.h"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace vdblic {

/// Where a run was after a step, and all it takes to go on from there (docs/survival.md).
struct Checkpoint {
    std::uint64_t steps = 0;         ///< that were made, preroll included
    double interval = 0;             ///< seconds of the last one
    double time = 0;                 ///< seconds, of the frame that the next step starts from
    std::int64_t frameSpacing = 0;   ///< FlowSequence::spacing()
    std::vector<std::string> inputs; ///< FlowSequence::stampOf() of every frame that had a part in it, in order
    VdbFile state;                   ///< FlowTexture::save()
};

/// Write a checkpoint in place of the one before, which stays valid until the new one is complete on disk.
/// @throws OutputError
void writeCheckpoint(const std::filesystem::path& path, const Checkpoint& checkpoint, const ParameterTexts& parameters);

/// Read a checkpoint. @param parameters of the run that is to go on from it
/// @throws InputError if it is damaged, none, or of another version, ParameterError if it was made with other
///         parameters; messages name the difference
[[nodiscard]] Checkpoint readCheckpoint(const std::filesystem::path& path, const ParameterTexts& parameters);

/// Refuse to go on from a checkpoint. @throws InputError naming it and the reason, and that it may be deleted
[[noreturn]] void refuseCheckpoint(const std::filesystem::path& path, const std::string& reason);

/// When a run writes its checkpoints.
class CheckpointSchedule {
  public:
    using Clock = std::chrono::steady_clock;

    /// @param every steps between checkpoints, 0 for none; nothing: so that they take next to no time, see isDue()
    explicit CheckpointSchedule(std::optional<int> every) : mEvery(every) {}

    [[nodiscard]] bool enabled() const { return mEvery != 0; }
    void stepDone() { ++mSteps; }

    /// By default a checkpoint is due half a minute after the last, or later, if need be, for writing them to take
    /// no more than a fiftieth of the time.
    [[nodiscard]] bool isDue() const;

    /// One was written. @param cost what that took
    void wrote(Clock::duration cost);

  private:
    std::optional<int> mEvery;
    int mSteps = 0; // since the last
    Clock::time_point mLast = Clock::now();
    Clock::duration mCost{}; // of the last
};

} // namespace vdblic
