/// The engine's benchmark: what each method costs and gives, how time grows with life span, size and sparsity, and the
/// integrator against OpenVDB's own. Everything in one run on one thread unless it says otherwise, so that ratios hold
/// where absolute times do not.
///
///     engine [--frames N] [--velocity PATTERN RANGE] [--json FILE]

#include "bench/engine/flow.h"
#include "bench/engine/integrators.h"
#include "bench/engine/methods.h"
#include "bench/engine/peak_memory.h"
#include "bench/engine/sweeps.h"

#include <nlohmann/json.hpp>
#include <openvdb/openvdb.h>
#include <tbb/global_control.h>

#include <cstdio>
#include <fstream>
#include <string>

int main(int argc, char** argv)
{
    using namespace vdblic;
    using namespace vdblic::bench;
    openvdb::initialize();
    int frames = 41;
    std::string velocity, range, output;
    for (int i = 1; i < argc; ++i) {
        const std::string option = argv[i];
        if (option == "--frames" && i + 1 < argc) {
            frames = std::stoi(argv[++i]);
        } else if (option == "--velocity" && i + 2 < argc) {
            velocity = argv[++i];
            range = argv[++i];
        } else if (option == "--json" && i + 1 < argc) {
            output = argv[++i];
        } else {
            std::fprintf(stderr, "engine [--frames N] [--velocity PATTERN RANGE] [--json FILE]\n");
            return 2;
        }
    }
    nlohmann::json report;
    report["memory"] = measurePeakMemory(); // first: a child's peak includes pages of its parent
    {
        const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        const BoxSize paper{144, 73, 81};
        const Flow flow = analyticFlow(paper, frames + 1, boxDomain(paper));
        report["integrators"] = compareIntegrators(flow);
        report["methods"] = compareMethods(flow, "The paper's grid, 144 x 73 x 81, abc flow, life span 4");
        if (!velocity.empty()) {
            report["methods_of_files"] = compareMethods(flowOfFiles(velocity, range), "The given files, life span 4");
        }
    }
    report["sweeps"] = sweepParameters();
    if (!output.empty()) std::ofstream(output) << report.dump(2) << '\n';
}
