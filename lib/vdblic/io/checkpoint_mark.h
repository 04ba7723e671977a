#pragma once

#include <filesystem>

namespace vdblic {

/// Metadata keys that identify a checkpoint, or a part of one.
struct CheckpointKeys {
    static constexpr const char *kSteps = "steps", *kInterval = "interval", *kTime = "time",
                                *kSpacing = "number_spacing", *kMotion = "scaled_motion";
};

/// Whether a file is a checkpoint of vdblic_advect or a part of one, by its content and not by its name. An unreadable
/// file counts as none, so only a recognised checkpoint is ever replaced or removed.
[[nodiscard]] bool isCheckpoint(const std::filesystem::path& path);

/// Check that a checkpoint can be written, over nothing or another checkpoint. @throws ParameterError, OutputError
void checkCheckpoint(const std::filesystem::path& path);

} // namespace vdblic
