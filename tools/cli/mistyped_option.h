#pragma once

#include <CLI/CLI.hpp>

namespace vdblic::cli {

/// Check that every argument that looks like an option is one, before the parser finds what else is missing.
/// @throws CLI::ExtrasError naming the first one that is not, and the nearest option
void checkOptions(const CLI::App& app, int argc, char** argv);

} // namespace vdblic::cli
