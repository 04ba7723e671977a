#include "cli/ranks.h"
#include "vdblic/mpi/mpi_exchange.h"

#include <cstdio>
#include <utility>

namespace vdblic::cli {

Ranks startRanks(int& argc, char**& argv)
{
    auto exchange = std::make_unique<MpiExchange>(argc, argv);
    if (!exchange->isFirst()) (void)!std::freopen("/dev/null", "w", stdout);
    const int onHost = exchange->onHost();
    return {std::move(exchange), onHost, "_mpi"};
}

} // namespace vdblic::cli
