#include "metadata.h"

#include "grid_arrays.h"
#include "text.h"
#include "vdblic/core/errors.h"

#include <fmt/format.h>
#include <pybind11/numpy.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>

namespace vdblic::python {
namespace {

namespace py = pybind11;

/// A number of a type of NumPy, which Python's own lack.
template<typename Number>
py::object numpyNumber(const char* type, Number value)
{
    return py::module_::import("numpy").attr(type)(value);
}

using SmallVectors = openvdb::TypeList<openvdb::Vec2i, openvdb::Vec2s, openvdb::Vec2d, openvdb::Vec3i, openvdb::Vec3s,
                                       openvdb::Vec3d, openvdb::Vec4i, openvdb::Vec4s, openvdb::Vec4d>;

/// A value of metadata, of a type that asMetadata() makes the same metadata of. A type that Python lacks stays
/// openvdb::Metadata.
py::object asObject(const openvdb::Metadata& metadata)
{
    py::object result = py::cast(metadata.copy());
    const auto take = [&](const auto& value) {
        using Value = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, float>) {
            result = numpyNumber("float32", value);
        } else if constexpr (std::is_same_v<Value, std::int32_t>) {
            result = numpyNumber("int32", value);
        } else if constexpr (openvdb::VecTraits<Value>::IsVec) {
            py::list items;
            for (int i = 0; i < Value::size; ++i) {
                const bool isSingle = std::is_same_v<typename Value::ValueType, float>;
                items.append(isSingle ? numpyNumber("float32", value[i]) : py::cast(value[i]));
            }
            result = py::tuple(items);
        } else if constexpr (std::is_same_v<Value, std::string>) {
            result = toText(value);
        } else {
            result = py::cast(value);
        }
    };
    using Known = openvdb::TypeList<bool, std::int32_t, std::int64_t, float, double, std::string>::Append<SmallVectors>;
    Known::foreach ([&](auto value) { // default values, for their types
        if (const auto* typed = dynamic_cast<const openvdb::TypedMetadata<decltype(value)>*>(&metadata))
            take(typed->value());
    });
    return result;
}

template<typename T>
openvdb::Metadata::Ptr typedMetadata(const T& value)
{
    return std::make_shared<openvdb::TypedMetadata<T>>(value);
}

/// 2 to 4 numbers as metadata. Null for another count.
template<typename Number>
openvdb::Metadata::Ptr vectorMetadata(const py::array& numbers)
{
    const auto of = py::array_t<Number, py::array::c_style | py::array::forcecast>(numbers);
    switch (of.size()) {
    case 2:
        return typedMetadata(openvdb::math::Vec2<Number>(of.data()));
    case 3:
        return typedMetadata(openvdb::math::Vec3<Number>(of.data()));
    case 4:
        return typedMetadata(openvdb::math::Vec4<Number>(of.data()));
    default:
        return nullptr;
    }
}

/// A value as metadata: whole numbers of Python have 64 bits, numbers of NumPy their own type, vectors that of their
/// items, but whole numbers 32 bits. Null if there is none.
openvdb::Metadata::Ptr asMetadata(const py::handle& value)
{
    if (py::isinstance<openvdb::Metadata>(value)) return value.cast<openvdb::Metadata::Ptr>();
    if (py::isinstance<py::str>(value)) return typedMetadata(fromText(py::reinterpret_borrow<py::str>(value)));
    const std::optional<py::array> array = asArray(value);
    if (!array || array->ndim() > 1) return nullptr;
    const py::array& numbers = *array;
    const char kind = numbers.dtype().kind();
    const auto bytes = numbers.attr("itemsize").cast<py::ssize_t>(); // pybind11 2.10 knows NumPy 1's structure only
    if (numbers.ndim() == 1) {
        using Limits = std::numeric_limits<std::int32_t>;
        if (kind == 'f') return bytes <= 4 ? vectorMetadata<float>(numbers) : vectorMetadata<double>(numbers);
        const bool fits = (kind == 'i' || kind == 'u') && numbers.size() > 0 &&
                          numbers.attr("max")().cast<double>() <= double(Limits::max()) &&
                          numbers.attr("min")().cast<double>() >= double(Limits::min());
        return fits ? vectorMetadata<std::int32_t>(numbers) : nullptr;
    }
    const py::object item = numbers.attr("item")();
    if (kind == 'b') return typedMetadata(item.cast<bool>());
    if (kind == 'f') return bytes <= 4 ? typedMetadata(item.cast<float>()) : typedMetadata(item.cast<double>());
    if (kind == 'i')
        return bytes <= 4 ? typedMetadata(item.cast<std::int32_t>()) : typedMetadata(item.cast<std::int64_t>());
    if (kind == 'u' && bytes <= 4) return typedMetadata(item.cast<std::int64_t>());
    return nullptr;
}

} // namespace

py::dict toDictionary(const openvdb::MetaMap& metadata)
{
    py::dict result;
    for (auto entry = metadata.beginMeta(); entry != metadata.endMeta(); ++entry)
        result[toText(entry->first)] = asObject(*entry->second);
    return result;
}

openvdb::MetaMap toMetadata(const py::dict& dictionary)
{
    openvdb::MetaMap metadata;
    for (const auto& [key, value] : dictionary) {
        const openvdb::Metadata::Ptr made = asMetadata(value);
        const bool isText = py::isinstance<py::str>(key);
        const std::string name = isText ? fromText(py::reinterpret_borrow<py::str>(key)) : "";
        if (isText && (name.empty() || name.size() > kLongestName)) {
            throw ParameterError(fmt::format("metadata {:.100}: a name has 1 to {} bytes",
                                             py::repr(key).cast<std::string>(), kLongestName));
        }
        if (!isText || !made) {
            throw ParameterError(fmt::format("metadata {:.100} cannot be {:.100}; it is a text, a number, true or "
                                             "false, or a tuple of 2 to 4 numbers",
                                             py::repr(key).cast<std::string>(), py::repr(value).cast<std::string>()));
        }
        metadata.insertMeta(name, *made);
    }
    return metadata;
}

} // namespace vdblic::python
