#pragma once

#include "vdblic/io/vdb_file.h"
#include "vdblic/run/parameter_texts.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace vdblic {

/// The position of a run between two steps.
struct RunPosition {
    std::uint64_t steps = 0;       ///< steps made, preroll included
    double interval = 0;           ///< seconds between the frames of the last step
    double time = 0;               ///< seconds, of the frame from or after which the next step starts
    std::int64_t frameSpacing = 0; ///< VelocitySequence::spacing()
    double motion = 1;             ///< VelocityFrame::motion
};

/// A part of a checkpoint's state in a separate file: of a large domain, or of a rank.
struct CheckpointPart {
    std::filesystem::path path; ///< beside the checkpoint
    openvdb::CoordBBox box;     ///< of its leaves in the texture
};

/// The state of a run between two steps, sufficient to continue it (docs/advect.md).
struct Checkpoint {
    RunPosition position;
    std::vector<std::string> inputs; ///< VelocitySequence::stampOf() of all frames that the steps used, in order
    std::vector<VdbFile> states;     ///< the whole state in one file, or none if there are parts
    std::vector<CheckpointPart> parts{};
};

/// Write a checkpoint. An older one of that name stays valid until the new one is complete on disk.
/// @throws OutputError
void writeCheckpoint(const std::filesystem::path& path, const Checkpoint& checkpoint, const ParameterTexts& parameters);

/// Read a checkpoint. @param parameters of the resuming run
/// @throws InputError if the file is damaged, no checkpoint, or of another version; ParameterError if it was made with
///         other parameters. Messages name the difference.
[[nodiscard]] Checkpoint readCheckpoint(const std::filesystem::path& path, const ParameterTexts& parameters);

/// Refuse to continue from a checkpoint.
/// @throws InputError, always: names the checkpoint and the reason, and says that it may be deleted
[[noreturn]] void refuseCheckpoint(const std::filesystem::path& path, const std::string& reason);

} // namespace vdblic
