#include "cli/tool.h"
#include "vdblic/field/synth.h"

#include <fmt/format.h>

int main(int argc, char** argv)
{
    vdblic::SynthParams params;
    vdblic::cli::Tool tool("vdblic_synth", "Make a velocity sequence of an analytic, unsteady flow.");
    tool.options(parametersOf(params));
    tool.usesScratch(1, [&] { return params.output; });
    const auto list = [] {
        for (const vdblic::AnalyticFlow& flow : vdblic::analyticFlows()) {
            fmt::print("{:<10}{}\n", flow.name, flow.description);
        }
        throw CLI::Success{}; // before the required options are missed
    };
    tool.app().add_flag_callback("--list", list, "Name the flows, each with a line about it, and exit.");
    return tool.run(argc, argv, [&](vdblic::Reporter& reporter) { vdblic::synthSequence(params, reporter); });
}
