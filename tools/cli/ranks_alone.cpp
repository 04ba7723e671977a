#include "cli/ranks.h"

namespace vdblic::cli {

Ranks startRanks(int& /*argc*/, char**& /*argv*/)
{
    return {std::make_unique<OneProcess>(), 1, ""};
}

} // namespace vdblic::cli
