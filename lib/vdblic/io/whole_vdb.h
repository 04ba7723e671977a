#pragma once

#include "vdblic/core/reporter.h"

#include <filesystem>

namespace vdblic {

/// Whether an output exists and is whole, by its header and checksums. @param reporter gets the reason if not
[[nodiscard]] bool isWholeVdb(const std::filesystem::path& output, Reporter& reporter);

} // namespace vdblic
