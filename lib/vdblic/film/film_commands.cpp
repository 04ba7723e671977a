#include "vdblic/core/printable.h"
#include "vdblic/film/film_plan.h"
#include "vdblic/run/advect_params.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic {
namespace {

std::string commandOf(std::string_view tool, const Parameters& parameters, const Given& given)
{
    std::string command(tool);
    for (const Parameter& parameter : parameters) {
        const auto words = given.find(std::string(parameter.key));
        if (words == given.end()) continue;
        const std::string option = parameter.option();
        if (!parameter.isPositional()) command += ' ' + option.substr(0, option.find(','));
        if (parameter.type == WordType::kFlag) continue;
        if (parameter.info.words.find(',') != std::string_view::npos) { // a list of names: AXIS,AXIS
            command += ' ' + shellWord(fmt::format("{}", fmt::join(words->second, ",")));
            continue;
        }
        for (const std::string& word : words->second)
            command += ' ' + shellWord(word);
    }
    return command;
}

} // namespace

std::string texturesOf(const std::string& stem, std::size_t run)
{
    return stem + (run == 0 ? "texture.%04d.vdb" : "texture.lines.%04d.vdb");
}

Given advectOf(const FilmPlan& plan, const std::string& stem, std::size_t run)
{
    Given advect = plan.runs[run];
    advect["output"] = {texturesOf(stem, run)};
    return advect;
}

Given renderOf(const FilmPlan& plan, const std::string& stem)
{
    Given render = plan.render;
    render["input"] = {texturesOf(stem, 0)};
    if (plan.runs.size() > 1) render["lines"] = {texturesOf(stem, 1)};
    return render;
}

std::vector<std::string> commandsOf(const FilmPlan& plan, const std::string& stem)
{
    AdvectParams advect;
    RenderParams render;
    std::vector<std::string> commands;
    for (std::size_t run = 0; run < plan.runs.size(); ++run)
        commands.push_back(commandOf("vdblic_advect", parametersOf(advect), advectOf(plan, stem, run)));
    if (plan.page.empty()) {
        commands.push_back(commandOf("vdblic_render", parametersOf(render), renderOf(plan, stem)));
        return commands;
    }
    std::string& page = commands.emplace_back(fmt::format("{} {}", kPageTool, shellWord(texturesOf(stem, 0))));
    for (const std::string& word : plan.page)
        page += ' ' + shellWord(word);
    return commands;
}

} // namespace vdblic
