#pragma once

#include "vdblic/core/reporter.h"

#include <filesystem>

namespace vdblic {

/// Whether an output is there and whole, by its header and its checksums. @param reporter is told why it is not
[[nodiscard]] bool isWholeVdb(const std::filesystem::path& output, Reporter& reporter);

} // namespace vdblic
