#include "view/state.h"

#include "cli/picture_options.h"
#include "vdblic/camera/camera_keys.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/json_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <utility>

namespace vdblic::view {
namespace {

using Json = nlohmann::json;

/// The options that a state may hold: all of a picture's that name no file.
constexpr const char* kOfStates[] = {"size",
                                     "stretch",
                                     "scale",
                                     "samples",
                                     "eye",
                                     "target",
                                     "up",
                                     "projection",
                                     "fov",
                                     "view-height",
                                     "orbit",
                                     "orbit-frames",
                                     "step",
                                     "look",
                                     "by",
                                     "color-by",
                                     "opacity-by",
                                     "colormap",
                                     "colors",
                                     "opacity",
                                     "range",
                                     "opacity-range",
                                     "color-scale",
                                     "opacity-scale",
                                     "modulate",
                                     "limb-darkening",
                                     "shading",
                                     "ambient",
                                     "diffuse",
                                     "specular",
                                     "shininess",
                                     "head-light",
                                     "light",
                                     "halo",
                                     "shadows",
                                     "depth-cue",
                                     "clip-plane",
                                     "clip-box",
                                     "roi-box",
                                     "solid",
                                     "solid-color",
                                     "background",
                                     "background-alpha",
                                     "annotate"};
/// Options that name files; the command line alone sets them.
constexpr const char* kFixed[] = {"texture", "transfer", "roi"};
/// Options that may be repeated, and how many numbers each takes.
constexpr std::pair<const char*, std::size_t> kRepeated[] = {{"light", 3}, {"clip-plane", 6}};
constexpr std::size_t kMostText = 10000, kMostRepeats = 64;

template<typename Names>
bool isOneOf(const Names& names, const std::string& name)
{
    return std::any_of(std::begin(names), std::end(names), [&](const char* known) { return name == known; });
}

/// A number as JSON; nothing for other texts.
std::optional<Json> numberIn(const std::string& text)
{
    Json number = Json::parse(text, nullptr, /*allow_exceptions=*/false);
    if (!number.is_number()) return std::nullopt;
    return number;
}

/// The value of an option in a state.
Json valueOf(const std::string& name, const std::vector<std::string>& texts)
{
    Json numbers = Json::array();
    for (const std::string& text : texts) {
        const auto number = numberIn(text);
        if (!number) return texts.front();
        numbers.push_back(*number);
    }
    for (const auto& [repeated, count] : kRepeated) {
        if (name != repeated) continue;
        Json lists = Json::array();
        for (std::size_t i = 0; i + count <= numbers.size(); i += count)
            lists.push_back(Json(
                std::vector<Json>(numbers.begin() + std::ptrdiff_t(i), numbers.begin() + std::ptrdiff_t(i + count))));
        return lists;
    }
    return numbers.size() == 1 ? numbers.front() : numbers;
}

bool isNumbers(const Json& value)
{
    return value.is_array() && !value.empty() && value.size() <= kMostRepeats &&
           std::all_of(value.begin(), value.end(), [](const Json& number) { return number.is_number(); });
}

void addArguments(std::vector<std::string>& arguments, const std::string& name, const Json& value)
{
    const std::string option = "--" + name;
    if (value.is_number()) {
        arguments.push_back(fmt::format("{}={}", option, value.dump()));
    } else if (value.is_string() && value.get_ref<const std::string&>().size() <= kMostText) {
        arguments.push_back(fmt::format("{}={}", option, value.get_ref<const std::string&>()));
    } else if (isNumbers(value)) {
        arguments.push_back(option);
        for (const Json& number : value)
            arguments.push_back(number.dump());
    } else if (value.is_array() && !value.empty() && value.size() <= kMostRepeats &&
               std::all_of(value.begin(), value.end(), isNumbers)) {
        for (const Json& part : value)
            addArguments(arguments, name, part);
    } else {
        throw ParameterError(fmt::format("\"{}\" must be a number, a text, numbers or lists of numbers", name));
    }
}

/// A word for a shell.
std::string quoted(const std::string& word)
{
    constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./:,@%";
    if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
    std::string result = "'";
    for (const char c : word)
        result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

} // namespace

Start startOf(const CLI::App& app, const SequenceParams& input)
{
    Start start{input, {}, Json::object(), {}};
    for (const CLI::Option* option : app.get_options()) {
        if (option->count() == 0 || option->get_lnames().empty()) continue;
        const std::string& name = option->get_lnames().front();
        const std::vector<std::string> texts = option->reduced_results();
        if (isOneOf(kFixed, name)) start.fixed.push_back(fmt::format("--{}={}", name, texts.front()));
        if (isOneOf(kOfStates, name)) start.state[name] = valueOf(name, texts);
        if (name == "solid" && texts.front() != "domain") start.solid = texts.front();
        if (name == "camera") {
            (void)readCameraKeys(texts.front());
            start.state["keys"] = readJson(texts.front())["keys"];
        }
    }
    return start;
}

std::vector<std::string> argumentsOf(const Start& start, const Json& state)
{
    if (!state.is_object()) throw ParameterError("a state must be an object");
    std::vector<std::string> arguments = start.fixed;
    for (const auto& [name, value] : state.items()) {
        if (name == "keys") continue;
        if (!isOneOf(kOfStates, name)) throw ParameterError(fmt::format("a state has no \"{:.60}\"", name));
        if (name == "solid" && value != "domain" && (start.solid.empty() || value != start.solid))
            throw ParameterError("\"solid\" must be domain or what the command line names");
        addArguments(arguments, name, value);
    }
    return arguments;
}

RenderParams paramsOf(const Start& start, const Json& state)
{
    RenderParams params;
    CLI::App app;
    const cli::PictureOptions options(app, params);
    std::vector<std::string> arguments = argumentsOf(start, state);
    std::reverse(arguments.begin(), arguments.end()); // as CLI11 takes them
    try {
        app.parse(std::move(arguments));
    } catch (const CLI::ParseError& error) {
        throw ParameterError(error.what());
    }
    options.apply();
    try {
        if (state.contains("keys")) params.motion.keys = parseCameraKeys(Json{{"keys", state["keys"]}});
    } catch (const InputError& error) {
        throw ParameterError(error.what());
    }
    params.input = start.input;
    params.validatePicture();
    return params;
}

std::string commandOf(const Start& start, const Json& state, const std::vector<std::string>& last)
{
    std::vector<std::string> words{"vdblic_render", start.input.pattern};
    if (!start.input.frames.empty()) words.insert(words.end(), {"--frames", start.input.frames});
    const std::vector<std::string> arguments = argumentsOf(start, state);
    words.insert(words.end(), arguments.begin(), arguments.end());
    words.insert(words.end(), last.begin(), last.end());
    std::string command;
    for (const std::string& word : words)
        command += (command.empty() ? "" : " ") + quoted(word);
    return command;
}

} // namespace vdblic::view
