#include "view/state.h"

#include "vdblic/camera/camera_keys.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/printable.h"
#include "vdblic/io/json_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <utility>

namespace vdblic::view {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostText = 10000, kMostRepeats = 64;
constexpr std::array<std::string_view, 5> kOfFiles = {"camera", "lines", "roi", "texture",
                                                      "transfer"}; // names of files or grids

bool namesFile(const Parameter& parameter)
{
    return std::find(kOfFiles.begin(), kOfFiles.end(), parameter.key) != kOfFiles.end();
}

/// The name of a parameter in a state: its option without dashes.
std::string nameOf(const Parameter& parameter)
{
    return parameter.option().substr(2);
}

/// The parameter that a state names; null if states do not hold it.
const Parameter* findInState(const Parameters& parameters, const std::string& name)
{
    const auto found = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const Parameter& parameter) { return nameOf(parameter) == name; });
    return found == parameters.end() || namesFile(*found) ? nullptr : &*found;
}

/// The value of a parameter in a state: a number, a text, numbers, or lists of those for what may be repeated.
Json valueOf(const Parameter& parameter, const Words& words)
{
    if (parameter.type == WordType::kText) return words.front();
    Json numbers = Json::array();
    for (const std::string& word : words)
        numbers.push_back(Json::parse(word));
    if (!parameter.repeats) return numbers.size() == 1 ? numbers.front() : numbers;
    Json lists = Json::array();
    for (std::size_t i = 0; i < numbers.size(); i += parameter.least) {
        const auto at = [&](std::size_t n) { return numbers.begin() + std::ptrdiff_t(n); };
        lists.push_back(Json(std::vector<Json>(at(i), at(i + parameter.least))));
    }
    return lists;
}

bool isNumbers(const Json& value)
{
    return value.is_array() && !value.empty() && value.size() <= kMostRepeats &&
           std::all_of(value.begin(), value.end(), [](const Json& number) { return number.is_number(); });
}

/// The words of a value in a state. @throws ParameterError
Words wordsOf(const std::string& name, const Json& value)
{
    if (value.is_number()) return {value.dump()};
    if (value.is_string() && value.get_ref<const std::string&>().size() <= kMostText) return {value.get<std::string>()};
    const bool areLists = value.is_array() && !value.empty() && value.size() <= kMostRepeats &&
                          std::all_of(value.begin(), value.end(), isNumbers);
    if (!isNumbers(value) && !areLists)
        throw ParameterError(fmt::format("\"{}\" must be a number, a text, numbers or lists of numbers", name));
    Words words;
    for (const Json& part : value) {
        const Words more = wordsOf(name, part);
        words.insert(words.end(), more.begin(), more.end());
    }
    return words;
}

/// The values of a state, by key. @throws ParameterError
Given givenBy(const Start& start, const Json& state, const Parameters& parameters)
{
    if (!state.is_object()) throw ParameterError("a state must be an object");
    Given given = start.fixed;
    for (const auto& [name, value] : state.items()) {
        if (name == "keys") continue;
        const Parameter* const parameter = findInState(parameters, name);
        if (!parameter) throw ParameterError(fmt::format("a state has no \"{:.60}\"", name));
        if (name == "solid" && value != "domain" && (start.solid.empty() || value != start.solid))
            throw ParameterError("\"solid\" must be domain or what the command line names");
        given[std::string(parameter->key)] = wordsOf(name, value);
    }
    if (given.contains("eye")) { // the camera was moved
        given.erase("view");
        given.erase("angles");
    }
    return given;
}

} // namespace

Start startOf(const Given& given, const SequenceParams& input)
{
    PictureParams params;
    Start start{input, {}, Json::object(), {}, traitsOf(input)};
    for (const Parameter& parameter : parametersOf(params)) {
        const auto words = given.find(std::string(parameter.key));
        if (words == given.end()) continue;
        parameter.check(words->second);
        const std::string name = nameOf(parameter);
        if (name == "camera") {
            (void)readCameraKeys(words->second.front());
            start.state["keys"] = readJson(words->second.front())["keys"];
        } else if (namesFile(parameter)) {
            start.fixed.insert(*words);
        } else {
            start.state[name] = valueOf(parameter, words->second);
        }
        if (name == "solid" && words->second.front() != "domain") start.solid = words->second.front();
    }
    return start;
}

std::vector<std::string> argumentsOf(const Start& start, const Json& state)
{
    PictureParams params;
    const Parameters parameters = parametersOf(params);
    std::vector<std::string> arguments;
    for (const auto& [key, words] : givenBy(start, state, parameters)) {
        const Parameter& parameter = *find(parameters, key);
        if (words.size() == 1) {
            arguments.push_back(fmt::format("{}={}", parameter.option(), words.front()));
            continue;
        }
        for (std::size_t i = 0; i < words.size(); ++i) {
            if (i % parameter.least == 0) arguments.push_back(parameter.option());
            arguments.push_back(words[i]);
        }
    }
    return arguments;
}

PicturePlan planOf(const Start& start, const Json& state)
{
    PictureParams params;
    const Parameters parameters = parametersOf(params);
    set(parameters, givenBy(start, state, parameters));
    try {
        if (state.contains("keys")) params.motion.keys = parseCameraKeys(Json{{"keys", state["keys"]}});
    } catch (const InputError& error) {
        throw ParameterError(error.what());
    }
    return resolve(params, start.traits);
}

std::string commandOf(const Start& start, const Json& state, const std::vector<std::string>& last)
{
    std::vector<std::string> words{"vdblic_render", start.input.pattern};
    if (!start.input.frames.empty()) words.insert(words.end(), {"--frames", start.input.frames});
    const std::vector<std::string> arguments = argumentsOf(start, state);
    words.insert(words.end(), arguments.begin(), arguments.end());
    words.insert(words.end(), last.begin(), last.end());
    return shellCommand(words);
}

std::string shellCommand(const std::vector<std::string>& words)
{
    std::string command;
    for (const std::string& word : words)
        command += (command.empty() ? "" : " ") + shellWord(word);
    return command;
}

} // namespace vdblic::view
