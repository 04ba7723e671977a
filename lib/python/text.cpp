#include "text.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

namespace vdblic::python {

namespace py = pybind11;

py::str toText(std::string_view text)
{
    PyObject* const made = PyUnicode_DecodeUTF8(text.data(), py::ssize_t(text.size()), "surrogateescape");
    if (!made) throw py::error_already_set();
    return py::reinterpret_steal<py::str>(made);
}

std::string fromText(const py::str& text)
{
    PyObject* const bytes = PyUnicode_AsEncodedString(text.ptr(), "utf-8", "surrogateescape");
    if (bytes) return py::reinterpret_steal<py::bytes>(bytes);
    PyErr_Clear();
    throw ParameterError(fmt::format("the text {:.100} cannot be written as UTF-8; leave its surrogates out",
                                     py::repr(text).cast<std::string>()));
}

std::vector<std::string> fromTexts(const py::sequence& texts)
{
    std::vector<std::string> result;
    for (const py::handle& text : texts) {
        if (!py::isinstance<py::str>(text))
            throw ParameterError(fmt::format("{:.100} is no name", py::repr(text).cast<std::string>()));
        result.push_back(fromText(py::reinterpret_borrow<py::str>(text)));
    }
    return result;
}

} // namespace vdblic::python
