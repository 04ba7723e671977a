#include "caller.h"

#include "options.h"
#include "vdblic/core/printable.h"

namespace vdblic::python {

namespace py = pybind11;

void Caller::progress(std::size_t done, std::size_t total)
{
    const py::gil_scoped_acquire acquire;
    mTell("progress", done, total);
}

bool Caller::stopRequested() const
{
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    return false;
}

void Caller::tell(const char* kind, std::string_view message)
{
    const py::gil_scoped_acquire acquire;
    mTell(kind, printable(withKeywords(message)));
}

} // namespace vdblic::python
