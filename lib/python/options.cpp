#include "options.h"

#include "text.h"
#include "vdblic/core/errors.h"

#include <fmt/ranges.h>

#include <map>
#include <string>

namespace vdblic::python {
namespace {

namespace py = pybind11;

ParameterError refusal(const Parameter& parameter, const py::handle& value)
{
    const bool isOneText = parameter.type == WordType::kText && parameter.choices.empty() && !parameter.isList();
    const std::string kind(isOneText && !parameter.info.words.empty() ? parameter.info.words : parameter.kind());
    const py::str line = py::str(" ").attr("join")(py::repr(value).attr("split")());
    return ParameterError(
        fmt::format("`{}` cannot be {:.100}; it is {}", parameter.key, line.cast<std::string>(), kind));
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

std::string wordOf(const Parameter& parameter, const py::handle& given)
{
    const py::object value = isNumpyNumber(given) ? given.attr("item")() : py::reinterpret_borrow<py::object>(given);
    if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
    const bool hasWord =
        py::isinstance<py::str>(value) || PyNumber_Check(value.ptr()) != 0 || py::hasattr(value, "__fspath__");
    if (isList(value) || !hasWord) throw refusal(parameter, given);
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

/// A list as the text that stands for it on a command line: `a,b` for [a, b], `0:x,1:y` for [(0, x), (1, y)].
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
    return words;
}

} // namespace

void setFrom(const py::dict& keywords, const Parameters& parameters)
{
    std::map<std::string, Words> given;
    for (const auto& [name, value] : keywords) {
        const std::string key = fromText(py::str(name));
        const Parameter* const parameter = find(parameters, key);
        if (!parameter) throw ParameterError(fmt::format("there is no parameter `{}`", key));
        if (!value.is_none()) given[key] = wordsOf(*parameter, value);
    }
    set(parameters, given);
}

py::list described(const Parameters& parameters)
{
    py::list list;
    for (const Parameter& parameter : parameters) {
        py::dict entry;
        entry["key"] = std::string(parameter.key);
        entry["text"] = std::string(parameter.text);
        entry["kind"] = parameter.kind();
        entry["unit"] = std::string(parameter.info.unit);
        entry["default"] = parameter.value();
        list.append(entry);
    }
    return list;
}

} // namespace vdblic::python
