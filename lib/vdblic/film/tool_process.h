#pragma once

#include "vdblic/core/reporter.h"

#include <filesystem>
#include <string>
#include <vector>

namespace vdblic {

/// The program of a tool of VDBLIC: beside the running program, else in a folder of PATH.
/// @throws ParameterError if there is none
[[nodiscard]] std::filesystem::path findTool(const std::string& name);

/// Run a tool of VDBLIC in a process of its own, and wait for it.
///
/// Its messages go to the reporter, the paths that it prints nowhere. A requested stop ends it, and leaves no file that
/// is not complete.
///
/// @throws ParameterError, InputError or OutputError by its exit status, with its message; Stopped
void runTool(const std::string& name, const std::vector<std::string>& arguments, Reporter& reporter);

} // namespace vdblic
