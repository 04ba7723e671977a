#include "cli/tool.h"
#include "vdblic/field/synth.h"

#include <fmt/format.h>

int main(int argc, char** argv)
{
    vdblic::SynthParams params;
    vdblic::cli::Tool tool("vdblic_synth", "Make a velocity sequence of an analytic, unsteady flow.");
    tool.options(parametersOf(params));
    tool.usesScratch(1, [&] { return params.output; });
    tool.answers("--list", "Name the flows, each with a line about it, and exit.", [] {
        std::string lines;
        for (const vdblic::AnalyticFlow& flow : vdblic::analyticFlows())
            lines += fmt::format("{:<10}{}\n", flow.name, flow.description);
        return lines;
    });
    return tool.run(argc, argv, [&](vdblic::Reporter& reporter) { vdblic::synthSequence(params, reporter); });
}
