#include "options.h"

#include "text.h"
#include "vdblic/core/errors.h"
#include "vdblic/run/advect_params.h"

#include <fmt/ranges.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>

namespace vdblic::python {
namespace {

namespace py = pybind11;

ParameterError refusal(const Parameter& parameter, const py::handle& value)
{
    const bool isOneText = parameter.type == WordType::kText && parameter.choices.empty() && !parameter.isList();
    const std::string kind(isOneText && !parameter.info.words.empty() ? parameter.info.words : parameter.kind());
    const py::str line = py::str(" ").attr("join")(py::repr(value).attr("split")());
    ParameterError error(
        fmt::format("`{}` cannot be {:.100}; it is {}", parameter.key, line.cast<std::string>(), kind));
    return error;
}

/// The parameters with keywords that are not their keys.
const std::map<std::string, std::string, std::less<>>& otherKeywords()
{
    static const auto kWords = [] {
        std::map<std::string, std::string, std::less<>> words;
        AdvectParams run;
        for (const Parameter& parameter : parametersOf(run)) {
            if (const std::string word = keywordOf(parameter); word != parameter.key)
                words.emplace(parameter.key, word);
        }
        return words;
    }();
    return kWords;
}

/// Whether a value is an array of no dimension or a number of NumPy.
bool isNumpyNumber(const py::handle& value)
{
    return py::hasattr(value, "ndim") && py::hasattr(value, "item") &&
           py::object(value.attr("ndim")).equal(py::int_(0));
}

bool isList(const py::handle& value)
{
    const bool isSequence = py::isinstance<py::sequence>(value) || py::hasattr(value, "__array__");
    return isSequence && !py::isinstance<py::str>(value) && !isNumpyNumber(value);
}

/// A duration of Python or NumPy in seconds. Nothing for other values.
std::optional<py::object> secondsOf(const py::handle& value)
{
    if (py::hasattr(value, "total_seconds")) return value.attr("total_seconds")();
    if (!isNumpyNumber(value) || !py::object(value.attr("dtype").attr("kind")).equal(py::str("m"))) return std::nullopt;
    return py::object(value / py::module_::import("numpy").attr("timedelta64")(1, "s"));
}

std::string wordOf(const Parameter& parameter, const py::handle& given)
{
    if (const std::optional<py::object> seconds = secondsOf(given)) {
        if (parameter.info.unit != "s") throw refusal(parameter, given);
        return fromText(py::str(seconds->attr("__float__")()));
    }
    const py::object value = isNumpyNumber(given) ? given.attr("item")() : py::reinterpret_borrow<py::object>(given);
    if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
    const bool hasWord =
        py::isinstance<py::str>(value) || PyNumber_Check(value.ptr()) != 0 || py::hasattr(value, "__fspath__");
    if (isList(value) || !hasWord) throw refusal(parameter, given);
    if (parameter.type == WordType::kInteger && py::isinstance<py::float_>(value) &&
        value.attr("is_integer")().cast<bool>())
        return fromText(py::str(py::int_(value)));
    std::string word = fromText(py::str(value));
    if (word.find('\0') != std::string::npos) throw refusal(parameter, given); // a path would end there
    return word;
}

void addWords(const Parameter& parameter, const py::handle& value, Words& words)
{
    if (!isList(value)) {
        words.push_back(wordOf(parameter, value));
        return;
    }
    for (const py::handle& item : py::iter(value))
        addWords(parameter, item, words);
}

/// A list as text of a command line: `a,b` for [a, b], `0:x,1:y` for [(0, x), (1, y)].
std::string listText(const Parameter& parameter, const py::handle& list)
{
    Words items;
    for (const py::handle& item : py::iter(list)) {
        Words parts;
        for (const py::handle& part : isList(item) ? py::iter(item) : py::iter(py::make_tuple(item))) {
            if (isList(part)) throw refusal(parameter, list);
            parts.push_back(wordOf(parameter, part));
        }
        items.push_back(fmt::format("{}", fmt::join(parts, ":")));
    }
    return fmt::format("{}", fmt::join(items, ","));
}

Words wordsOf(const Parameter& parameter, const py::handle& value)
{
    const bool isOneText = parameter.type == WordType::kText && parameter.most == 1;
    if (isOneText && isList(value)) return {listText(parameter, value)};
    Words words;
    addWords(parameter, value, words);
    const bool isSize = parameter.type == WordType::kInteger && parameter.least == 2 && parameter.most == 2;
    if (isSize && words.size() == 1) words.push_back(words.front());
    return words;
}

} // namespace

std::string keywordOf(const Parameter& parameter)
{
    if (parameter.isPositional()) return std::string(parameter.key);
    std::string option = parameter.option();
    option.erase(0, option.rfind("--") + 2);
    std::replace(option.begin(), option.end(), '-', '_');
    return option == "with" ? "with_" : option;
}

std::string withKeywords(std::string_view message)
{
    std::string result(message);
    for (const auto& [key, word] : otherKeywords()) {
        const std::string quoted = fmt::format("`{}`", key);
        for (std::size_t at = result.find(quoted); at != std::string::npos; at = result.find(quoted, at + 1))
            result.replace(at + 1, key.size(), word);
    }
    return result;
}

void setFrom(const py::dict& keywords, const Parameters& parameters)
{
    std::map<std::string, Words> given;
    for (const auto& [name, value] : keywords) {
        const std::string keyword = fromText(py::str(name));
        const auto parameter = std::find_if(parameters.begin(), parameters.end(),
                                            [&](const Parameter& known) { return keywordOf(known) == keyword; });
        if (parameter == parameters.end()) throw ParameterError(fmt::format("there is no parameter `{}`", keyword));
        if (!value.is_none()) given[std::string(parameter->key)] = wordsOf(*parameter, value);
    }
    set(parameters, given);
}

py::list described(const Parameters& parameters)
{
    py::list list;
    for (const Parameter& parameter : parameters) {
        py::dict entry;
        constexpr std::array<const char*, 4> kNamesOfTypes = {"flag", "integer", "number", "text"};
        entry["key"] = keywordOf(parameter);
        entry["text"] = std::string(parameter.text);
        entry["kind"] = parameter.kind();
        entry["unit"] = std::string(parameter.info.unit);
        entry["default"] = parameter.value();
        entry["type"] = kNamesOfTypes[std::size_t(parameter.type)];
        entry["choices"] = py::tuple(py::cast(parameter.choices));
        entry["several"] = parameter.most > 1;
        list.append(entry);
    }
    return list;
}

} // namespace vdblic::python
