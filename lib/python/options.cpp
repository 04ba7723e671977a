#include "options.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <map>
#include <string>

namespace vdblic::python {
namespace {

namespace py = pybind11;

void addWords(const std::string& key, const py::handle& value, Words& words)
{
    if (py::isinstance<py::bool_>(value)) {
        words.emplace_back(value.cast<bool>() ? "true" : "false");
    } else if (py::isinstance<py::str>(value)) {
        words.push_back(value.cast<std::string>());
    } else if (py::isinstance<py::sequence>(value) || py::hasattr(value, "__array__")) {
        for (const py::handle& item : py::iter(value))
            addWords(key, item, words);
    } else if (PyNumber_Check(value.ptr()) != 0 || py::hasattr(value, "__fspath__")) {
        words.push_back(py::str(value).cast<std::string>());
    } else {
        throw ParameterError(fmt::format("`{}` cannot be {:.100}", key, py::repr(value).cast<std::string>()));
    }
}

} // namespace

void setFrom(const py::dict& keywords, const Parameters& parameters)
{
    std::map<std::string, Words> given;
    for (const auto& [name, value] : keywords) {
        const auto key = name.cast<std::string>();
        if (!find(parameters, key)) throw ParameterError(fmt::format("there is no parameter `{}`", key));
        if (!value.is_none()) addWords(key, value, given[key]);
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
        entry["expert"] = parameter.info.isExpert;
        list.append(entry);
    }
    return list;
}

} // namespace vdblic::python
