#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic::python {

/// Bytes of a name that readers of .vdb files take.
inline constexpr std::size_t kLongestName = 4096;

/// A text of a file as Python's: bytes that are no UTF-8 become lone surrogates, as in Python's file names (PEP 383).
[[nodiscard]] pybind11::str toText(std::string_view text);
/// The bytes of a text; the inverse of toText(). @throws ParameterError for other surrogates
[[nodiscard]] std::string fromText(const pybind11::str& text);
/// fromText() of each item. @throws ParameterError, also if an item is no text
[[nodiscard]] std::vector<std::string> fromTexts(const pybind11::sequence& texts);

} // namespace vdblic::python
