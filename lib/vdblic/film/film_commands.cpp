#include "vdblic/core/printable.h"
#include "vdblic/film/film_plan.h"
#include "vdblic/render/render_params.h"
#include "vdblic/run/advect_params.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic {
namespace {

std::string commandOf(std::string_view tool, const Parameters& parameters, const std::map<std::string, Words>& given)
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

std::vector<std::string> commandsOf(const FilmPlan& plan, const std::string& textures)
{
    AdvectParams advect;
    RenderParams render;
    std::map<std::string, Words> first = plan.advect, second = plan.render;
    first["output"] = second["input"] = {textures};
    std::string command = fmt::format("{} {}", kPageTool, shellWord(textures));
    for (const std::string& word : plan.page)
        command += ' ' + shellWord(word);
    if (plan.page.empty()) command = commandOf("vdblic_render", parametersOf(render), second);
    return {commandOf("vdblic_advect", parametersOf(advect), first), command};
}

} // namespace vdblic
