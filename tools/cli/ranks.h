#pragma once

#include "vdblic/core/exchange.h"

#include <memory>
#include <string>

namespace vdblic::cli {

/// The processes that share a tool's job, and the suffix of the tool's name.
struct Ranks {
    std::unique_ptr<Exchange> exchange;
    int onHost = 1; ///< processes that share this machine's memory
    std::string suffix;

    [[nodiscard]] std::string toolName(const char* name) const { return name + suffix; }
};

/// Join the other processes. Of several only rank 0 prints. A tool is linked with one of two definitions: in
/// ranks_alone.cpp a process is alone, in ranks_mpi.cpp MPI started it.
[[nodiscard]] Ranks startRanks(int& argc, char**& argv);

} // namespace vdblic::cli
