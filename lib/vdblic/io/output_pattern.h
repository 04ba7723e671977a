#pragma once

#include "vdblic/io/sequence.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace vdblic {

/// Check that a further output of a run does not have the name of a frame. @throws ParameterError
void checkNoFrame(const std::filesystem::path& output, const FramePattern& frames);

/// Check that an output has one of these extensions, in lower or upper case. @throws ParameterError
void checkExtension(const std::filesystem::path& path, const std::vector<std::string>& extensions);
/// Check that a pattern can name `frames` different outputs. @throws ParameterError
void checkOutputPattern(const FramePattern& pattern, std::size_t frames);
/// Check that the outputs of these frames have different names and can be written. @throws ParameterError, OutputError
void checkOutputs(const FramePattern& pattern, const std::vector<std::int64_t>& frames);

} // namespace vdblic
