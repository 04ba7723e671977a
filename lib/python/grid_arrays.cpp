#include "grid_arrays.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"

#include <fmt/format.h>
#include <openvdb/tools/Dense.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdblic::python {
namespace {

namespace py = pybind11;

/// An array of a box, with the given number of values a voxel: none for a plain (x, y, z).
template<typename T>
py::array_t<T> boxArray(const openvdb::CoordBBox& box, int components)
{
    const openvdb::Coord size = box.empty() ? openvdb::Coord(0) : box.dim();
    std::vector<py::ssize_t> shape = {size.x(), size.y(), size.z()};
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
    const double voxels = box.empty() ? 0 : double(box.dim().x()) * box.dim().y() * box.dim().z();
    checkMemory(voxels * (sizeof(ValueT) + 1), fmt::format("grid '{}': the box of its voxels", grid.getName()),
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
    const auto grid = GridT::create();
    const openvdb::CoordBBox box(origin, origin + size - openvdb::Coord(1));
    const openvdb::Coord first = origin & ~(int(Leaf::DIM) - 1), last = box.max() & ~(int(Leaf::DIM) - 1);
    std::vector<std::unique_ptr<Leaf>> leaves;
    for (int x = first.x(); x <= last.x(); x += Leaf::DIM)
        for (int y = first.y(); y <= last.y(); y += Leaf::DIM)
            for (int z = first.z(); z <= last.z(); z += Leaf::DIM)
                leaves.push_back(
                    std::make_unique<Leaf>(openvdb::Coord(x, y, z), openvdb::zeroVal<typename GridT::ValueType>()));
    tbb::parallel_for(std::size_t(0), leaves.size(), [&](std::size_t i) {
        Leaf& leaf = *leaves[i];
        openvdb::CoordBBox part = leaf.getNodeBoundingBox();
        part.intersect(box);
        for (auto voxel = part.begin(); voxel; ++voxel) {
            const openvdb::Coord at = *voxel - origin;
            const std::size_t index = (std::size_t(at.x()) * size.y() + at.y()) * size.z() + at.z();
            if (!active || active[index]) leaf.setValueOn(*voxel, values[index]);
        }
    });
    for (std::unique_ptr<Leaf>& leaf : leaves)
        if (!leaf->isEmpty()) grid->tree().addLeaf(leaf.release());
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
        return openvdb::math::Transform::createLinearTransform(rows);
    } catch (const openvdb::Exception& error) {
        throw ParameterError(fmt::format("`transform` cannot be used: {}", error.what()));
    }
}

} // namespace

bool isOfNumbers(const openvdb::GridBase& grid)
{
    return (grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>() ||
            grid.isType<openvdb::Vec3SGrid>() || grid.isType<openvdb::Vec3DGrid>()) &&
           grid.transform().isLinear();
}

py::object matrixOf(const openvdb::math::Transform& transform)
{
    const openvdb::Mat4d rows = transform.baseMap()->getAffineMap()->getMat4();
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
    if (grid.isType<openvdb::Vec3SGrid>()) result = arraysOf<openvdb::Vec3SGrid>(grid, box);
    if (grid.isType<openvdb::Vec3DGrid>()) result = arraysOf<openvdb::Vec3DGrid>(grid, box);
    result["name"] = grid.getName();
    result["transform"] = matrixOf(grid.transform());
    result["staggered"] = grid.getGridClass() == openvdb::GRID_STAGGERED;
    result["metadata"] = toDictionary(static_cast<const openvdb::MetaMap&>(grid));
    return result;
}

openvdb::GridBase::Ptr toGrid(const py::dict& dictionary)
{
    const auto values = py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(dictionary["values"]);
    const bool isVector = values && values.ndim() == 4 && values.shape(3) == 3;
    if (!values || !(isVector || values.ndim() == 3))
        throw ParameterError("`values` is no array of numbers (x, y, z) or (x, y, z, 3)");
    const openvdb::Coord size(int(values.shape(0)), int(values.shape(1)), int(values.shape(2)));
    py::array_t<bool, py::array::c_style | py::array::forcecast> active;
    if (!dictionary["active"].is_none()) {
        active = py::array_t<bool, py::array::c_style | py::array::forcecast>::ensure(dictionary["active"]);
        if (!active || active.ndim() != 3 || active.shape(0) != size.x() || active.shape(1) != size.y() ||
            active.shape(2) != size.z())
            throw ParameterError(
                fmt::format("`active` is no mask of {} x {} x {} voxels", size.x(), size.y(), size.z()));
    }
    const auto [x, y, z] = dictionary["origin"].cast<std::array<int, 3>>();
    const float* numbers = values.data();
    const bool* mask = dictionary["active"].is_none() ? nullptr : active.data();
    openvdb::GridBase::Ptr grid;
    {
        const py::gil_scoped_release release;
        if (size.x() * size.y() * size.z() == 0) {
            grid = isVector ? openvdb::GridBase::Ptr(openvdb::Vec3SGrid::create()) : openvdb::FloatGrid::create();
        } else if (isVector) {
            grid = gridOf<openvdb::Vec3SGrid>(reinterpret_cast<const openvdb::Vec3f*>(numbers), mask, size, {x, y, z});
        } else {
            grid = gridOf<openvdb::FloatGrid>(numbers, mask, size, {x, y, z});
        }
    }
    grid->insertMeta(toMetadata(dictionary["metadata"]));
    grid->setName(dictionary["name"].cast<std::string>());
    grid->setTransform(transformOf(dictionary["transform"]));
    if (dictionary["staggered"].cast<bool>()) grid->setGridClass(openvdb::GRID_STAGGERED);
    return grid;
}

py::dict toDictionary(const openvdb::MetaMap& metadata)
{
    py::dict result;
    for (auto entry = metadata.beginMeta(); entry != metadata.endMeta(); ++entry) {
        const py::str key(entry->first);
        const openvdb::Metadata& value = *entry->second;
        if (const auto* real = dynamic_cast<const openvdb::DoubleMetadata*>(&value))
            result[key] = real->value();
        else if (const auto* single = dynamic_cast<const openvdb::FloatMetadata*>(&value))
            result[key] = single->value();
        else if (const auto* whole = dynamic_cast<const openvdb::Int64Metadata*>(&value))
            result[key] = whole->value();
        else if (const auto* small = dynamic_cast<const openvdb::Int32Metadata*>(&value))
            result[key] = small->value();
        else if (const auto* truth = dynamic_cast<const openvdb::BoolMetadata*>(&value))
            result[key] = truth->value();
        else
            result[key] = value.str();
    }
    return result;
}

openvdb::MetaMap toMetadata(const py::dict& dictionary)
{
    openvdb::MetaMap metadata;
    for (const auto& [key, value] : dictionary) {
        const auto name = key.cast<std::string>();
        if (py::isinstance<py::bool_>(value))
            metadata.insertMeta(name, openvdb::BoolMetadata(value.cast<bool>()));
        else if (py::isinstance<py::int_>(value))
            metadata.insertMeta(name, openvdb::Int64Metadata(value.cast<std::int64_t>()));
        else if (py::isinstance<py::float_>(value))
            metadata.insertMeta(name, openvdb::DoubleMetadata(value.cast<double>()));
        else
            metadata.insertMeta(name, openvdb::StringMetadata(py::str(value)));
    }
    return metadata;
}

openvdb::GridPtrVec toGrids(const py::list& dictionaries)
{
    openvdb::GridPtrVec grids;
    for (const py::handle& dictionary : dictionaries)
        grids.push_back(toGrid(dictionary.cast<py::dict>()));
    return grids;
}

} // namespace vdblic::python
