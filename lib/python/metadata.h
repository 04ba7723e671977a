#pragma once

#include <openvdb/openvdb.h>
#include <pybind11/pybind11.h>

namespace vdblic::python {

/// Metadata as values of Python, which toMetadata() makes the same metadata of: bool, str, int (64 bits), float
/// (double), NumPy's int32 and float32, and tuples of 2 to 4 numbers for vectors. Other types stay
/// openvdb::Metadata.
[[nodiscard]] pybind11::dict toDictionary(const openvdb::MetaMap& metadata);
[[nodiscard]] openvdb::MetaMap toMetadata(const pybind11::dict& dictionary); ///< @throws ParameterError naming the key

} // namespace vdblic::python
