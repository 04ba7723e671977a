#include "grid_arrays.h"

#include "metadata.h"
#include "text.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/extent.h"
#include "vdblic/core/memory.h"
#include "vdblic/io/affine_rows.h"
#include "vdblic/io/invertible.h"
#include "vdblic/lines/line_grid.h"

#include <fmt/format.h>
#include <openvdb/tools/Dense.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace vdblic::python {
namespace {

namespace py = pybind11;

/// OpenVDB numbers grids of one name behind it.
constexpr char kSeparator = '\x1e';

/// An array of a box, with the given number of values a voxel: none for a plain (x, y, z).
template<typename T>
py::array_t<T> boxArray(const openvdb::CoordBBox& box, int components)
{
    const auto [x, y, z] = extentOf(box);
    std::vector<py::ssize_t> shape = {x, y, z};
    if (components > 1) shape.push_back(components);
    return py::array_t<T>(shape);
}

template<typename GridT>
py::dict arraysOf(const openvdb::GridBase& base, const openvdb::CoordBBox& box)
{
    using ValueT = typename GridT::ValueType;
    constexpr int kComponents = openvdb::VecTraits<ValueT>::Size;
    using Number = typename openvdb::VecTraits<ValueT>::ElementType;
    const auto& grid = static_cast<const GridT&>(base);
    checkMemory(voxelsOf(box) * (sizeof(ValueT) + 1), fmt::format("grid '{}': its bounding box", grid.getName()),
                "cut the grid");
    auto values = boxArray<Number>(box, kComponents);
    auto active = boxArray<bool>(box, 1);
    if (!box.empty()) {
        auto* valueData = reinterpret_cast<ValueT*>(values.mutable_data());
        bool* activeData = active.mutable_data();
        const py::gil_scoped_release release;
        openvdb::tools::Dense<ValueT, openvdb::tools::LayoutZYX> dense(box, valueData);
        openvdb::tools::copyToDense(grid, dense);
        const openvdb::BoolTree topology(grid.tree(), false, true, openvdb::TopologyCopy());
        openvdb::tools::Dense<bool, openvdb::tools::LayoutZYX> mask(box, activeData);
        openvdb::tools::copyToDense(topology, mask);
    }
    py::dict result;
    result["values"] = values;
    result["active"] = active;
    result["origin"] = py::make_tuple(box.min().x(), box.min().y(), box.min().z());
    if (box.empty()) result["origin"] = py::make_tuple(0, 0, 0);
    return result;
}

/// A tree of values over a box, active where a mask is.
template<typename GridT>
typename GridT::Ptr gridOf(const typename GridT::ValueType* values, const bool* active, const openvdb::Coord& size,
                           const openvdb::Coord& origin)
{
    using Leaf = typename GridT::TreeType::LeafNodeType;
    auto grid = GridT::create();
    const openvdb::CoordBBox box(origin, origin + size - openvdb::Coord(1));
    const openvdb::Coord first = origin & ~(int(Leaf::DIM) - 1), last = box.max() & ~(int(Leaf::DIM) - 1);
    const openvdb::Coord counts = ((last - first) >> Leaf::LOG2DIM) + openvdb::Coord(1);
    const std::size_t most = std::size_t(counts.x()) * counts.y() * counts.z();
    std::vector<std::unique_ptr<Leaf>> leaves(most); // a leaf exists only where a voxel is active
    tbb::parallel_for(std::size_t(0), most, [&](std::size_t i) {
        const openvdb::Coord number(int(i / counts.z() / counts.y()), int(i / counts.z() % counts.y()),
                                    int(i % counts.z()));
        const openvdb::Coord corner = first + (number << Leaf::LOG2DIM);
        openvdb::CoordBBox part = openvdb::CoordBBox::createCube(corner, Leaf::DIM);
        part.intersect(box);
        for (auto voxel = part.begin(); voxel; ++voxel) {
            const openvdb::Coord at = *voxel - origin;
            const std::size_t index = (std::size_t(at.x()) * size.y() + at.y()) * size.z() + at.z();
            if (active && !active[index]) continue;
            if (!leaves[i]) leaves[i] = std::make_unique<Leaf>(corner, openvdb::zeroVal<typename GridT::ValueType>());
            leaves[i]->setValueOn(*voxel, values[index]);
        }
    });
    for (std::unique_ptr<Leaf>& leaf : leaves)
        if (leaf) grid->tree().addLeaf(leaf.release());
    return grid;
}

openvdb::math::Transform::Ptr transformOf(const py::object& matrix)
{
    const auto numbers = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(matrix);
    if (!numbers || numbers.ndim() != 2 || numbers.shape(0) != 4 || numbers.shape(1) != 4)
        throw ParameterError("`transform` is no matrix of 4 x 4 numbers");
    openvdb::Mat4d rows; // OpenVDB's vectors are rows
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            rows(j, i) = numbers.at(i, j);
    try {
        openvdb::math::Transform::Ptr transform = openvdb::math::Transform::createLinearTransform(rows);
        if (isInvertible(*transform)) return transform;
    } catch (const openvdb::Exception& error) {
        throw ParameterError(fmt::format("`transform` cannot be used: {}", error.what()));
    }
    throw ParameterError("`transform` flattens space, or is not finite; give the voxels a size");
}

/// A member of a grid's dictionary. @param kind the required type
template<typename T>
T memberOf(const py::dict& dictionary, const char* key, const char* kind)
{
    try {
        if constexpr (std::is_base_of_v<py::object, T>) { // a cast would convert anything to it
            if (!py::isinstance<T>(dictionary[key])) throw py::cast_error();
        }
        return dictionary[key].cast<T>();
    } catch (const py::cast_error&) {
        throw ParameterError(
            fmt::format("`{}` cannot be {:.100}; it is {}", key, py::repr(dictionary[key]).cast<std::string>(), kind));
    }
}

openvdb::GridBase::Ptr gridOf(const py::dict& dictionary)
{
    const std::optional<py::array> given = asArray(dictionary["values"]);
    if (given && given->dtype().kind() == 'c') throw ParameterError("`values` are complex; a grid holds real numbers");
    const auto values =
        py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(given ? py::object(*given) : py::none());
    const bool isVector = values && values.ndim() == 4 && values.shape(3) == 3;
    if (!values || !(isVector || values.ndim() == 3)) {
        const std::string shape = values ? py::str(values.attr("shape")).cast<std::string>() : "";
        throw ParameterError(fmt::format("`values` is no array of numbers (x, y, z) or (x, y, z, 3){}{}",
                                         shape.empty() ? "" : "; its shape is ", shape));
    }
    const std::array<std::int64_t, 3> shape = {values.shape(0), values.shape(1), values.shape(2)};
    const auto origin = memberOf<std::array<int, 3>>(dictionary, "origin", "3 whole numbers");
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t first = origin[axis], last = first + shape[axis] - 1;
        if (std::max(std::abs(first), std::abs(last)) <= kFarthestIndex) continue;
        throw ParameterError(fmt::format("`origin` {} {} {} puts voxels at the indices {} to {} along axis {}; they "
                                         "lie within ±{}",
                                         origin[0], origin[1], origin[2], first, last, axis, kFarthestIndex));
    }
    const openvdb::Coord size{int(shape[0]), int(shape[1]), int(shape[2])};
    py::array_t<bool, py::array::c_style | py::array::forcecast> active;
    if (!dictionary["active"].is_none()) {
        active = py::array_t<bool, py::array::c_style | py::array::forcecast>::ensure(dictionary["active"]);
        if (!active || active.ndim() != 3 || active.shape(0) != size.x() || active.shape(1) != size.y() ||
            active.shape(2) != size.z())
            throw ParameterError(
                fmt::format("`active` is no mask of {} x {} x {} voxels", size.x(), size.y(), size.z()));
    }
    const auto [x, y, z] = origin;
    const float* numbers = values.data();
    const bool* mask = dictionary["active"].is_none() ? nullptr : active.data();
    openvdb::GridBase::Ptr grid;
    {
        const py::gil_scoped_release release;
        if (values.size() == 0) {
            grid = isVector ? openvdb::GridBase::Ptr(openvdb::Vec3SGrid::create()) : openvdb::FloatGrid::create();
        } else if (isVector) {
            grid = gridOf<openvdb::Vec3SGrid>(reinterpret_cast<const openvdb::Vec3f*>(numbers), mask, size, {x, y, z});
        } else {
            grid = gridOf<openvdb::FloatGrid>(numbers, mask, size, {x, y, z});
        }
    }
    grid->insertMeta(toMetadata(memberOf<py::dict>(dictionary, "metadata", "a dictionary")));
    const std::string name = fromText(memberOf<py::str>(dictionary, "name", "a text"));
    if (name.size() > kLongestName || name.find(kSeparator) != std::string::npos) {
        throw ParameterError(
            fmt::format("`name` has more than {} bytes, or \\x1e, which ends names in .vdb files", kLongestName));
    }
    grid->setName(name);
    grid->setTransform(transformOf(dictionary["transform"]));
    if (memberOf<bool>(dictionary, "staggered", "true or false")) {
        grid->removeMeta(openvdb::GridBase::META_GRID_CLASS); // may be of another type
        grid->setGridClass(openvdb::GRID_STAGGERED);
    }
    return grid;
}

} // namespace

std::optional<py::array> asArray(const py::handle& value)
{
    try {
        return py::array(py::module_::import("numpy").attr("asarray")(value));
    } catch (const py::error_already_set& error) { // an interruption is rethrown
        if (!error.matches(PyExc_ValueError) && !error.matches(PyExc_TypeError)) throw;
        return std::nullopt;
    }
}

bool isOfNumbers(const openvdb::GridBase& grid)
{
    return (grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>() ||
            grid.isType<openvdb::Vec3SGrid>() || grid.isType<openvdb::Vec3DGrid>()) &&
           grid.transform().isLinear();
}

bool hasArrays(const openvdb::GridBase& grid)
{
    return isOfNumbers(grid) || (grid.isType<openvdb::Int32Grid>() && grid.transform().isLinear());
}

py::object matrixOf(const openvdb::math::Transform& transform)
{
    const openvdb::Mat4d rows = affineRows(transform);
    py::array_t<double> matrix({4, 4});
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            matrix.mutable_at(i, j) = rows(j, i);
    return matrix;
}

py::dict toDictionary(const openvdb::GridBase& grid, const std::optional<openvdb::CoordBBox>& over)
{
    const openvdb::CoordBBox box = over ? *over : grid.evalActiveVoxelBoundingBox();
    py::dict result;
    if (grid.isType<openvdb::FloatGrid>()) result = arraysOf<openvdb::FloatGrid>(grid, box);
    if (grid.isType<openvdb::DoubleGrid>()) result = arraysOf<openvdb::DoubleGrid>(grid, box);
    if (grid.isType<openvdb::Int32Grid>()) result = arraysOf<openvdb::Int32Grid>(grid, box);
    if (grid.isType<openvdb::Vec3SGrid>()) result = arraysOf<openvdb::Vec3SGrid>(grid, box);
    if (grid.isType<openvdb::Vec3DGrid>()) result = arraysOf<openvdb::Vec3DGrid>(grid, box);
    result["name"] = toText(grid.getName());
    result["transform"] = matrixOf(grid.transform());
    result["staggered"] = grid.getGridClass() == openvdb::GRID_STAGGERED;
    result["metadata"] = toDictionary(static_cast<const openvdb::MetaMap&>(grid));
    return result;
}

openvdb::GridBase::Ptr toGrid(const py::dict& dictionary)
{
    try {
        return gridOf(dictionary);
    } catch (const ParameterError& error) {
        throw ParameterError(
            fmt::format("grid {:.100}: {}", py::repr(dictionary["name"]).cast<std::string>(), error.what()));
    }
}

bool isOfLines(const openvdb::GridBase& grid)
{
    return grid.getName() == kLineGrid && grid.valueType() == "ptdataidx32";
}

py::list toList(openvdb::GridPtrVec grids)
{
    py::list list;
    for (openvdb::GridBase::Ptr& grid : grids) {
        if (hasArrays(*grid)) list.append(toDictionary(*grid));
        if (isOfLines(*grid)) list.append(StoredLines{grid});
        grid.reset();
    }
    return list;
}

VdbFile toVolume(const py::list& grids, const py::dict& metadata, const std::string& name)
{
    VdbFile volume{{}, {}, name};
    try {
        for (const py::handle& grid : grids)
            volume.grids.push_back(py::isinstance<StoredLines>(grid) ? grid.cast<StoredLines&>().grid
                                                                     : toGrid(grid.cast<py::dict>()));
        volume.metadata = toMetadata(metadata);
    } catch (const ParameterError& error) {
        throw ParameterError(name.empty() ? error.what() : fmt::format("{}: {}", name, error.what()));
    }
    return volume;
}

} // namespace vdblic::python
