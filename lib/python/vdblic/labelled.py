"""Data of xarray and VTK, whose axes have names and coordinates, as grids.

Neither package is imported unless the data are an object of it. Units, and Datasets that have longitude, latitude or
pressure, are those of vdblic_import.
"""

from __future__ import annotations

import datetime
import importlib
import re
from collections.abc import Iterator
from typing import Any

import numpy

_SECOND = numpy.timedelta64(1, "s")
_ADVICE = "(of a Dataset with u and v on longitude, latitude and heights or pressures, the velocity is made)"


def is_labelled(data: Any) -> bool:
    """Whether data are of xarray or of VTK."""
    return _is_xarray(data) or all(hasattr(data, name) for name in ("GetPointData", "GetFieldData", "IsA"))


def moments(data: Any) -> tuple[Iterator[Any], int]:
    """An iterator over the times of labelled data, as pairs (time, data) if times are known, and their number."""
    time = _time_of(data) if _is_xarray(data) else None
    if time is None or time not in data.dims:
        return iter([data]), 1
    return _moments(data, time), data.sizes[time]


def _moments(data, time):
    for index in range(data.sizes[time]):
        part = data.isel({time: index})
        yield (_moment(part, time), part) if time in part.coords else part


def clock(time: Any, first: Any = None) -> dict:
    """The metadata of a time: seconds, or a date of NumPy or Python, counted from a first one. Raises ValueError."""
    if isinstance(time, datetime.datetime):
        time = numpy.datetime64(time)
    if isinstance(time, numpy.datetime64) and not numpy.isnat(time):
        start = numpy.datetime64(0, "s") if first is None else numpy.datetime64(first)
        return {"time": float((time - start) / _SECOND), "start": str(numpy.datetime_as_string(start, unit="s"))}
    try:
        seconds = float(time / _SECOND if isinstance(time, numpy.timedelta64) else time)
    except (TypeError, ValueError):
        seconds = numpy.nan
    if not numpy.isfinite(seconds):
        raise ValueError(f"the time {time!r:.100} is neither a number of seconds nor a date of NumPy or Python")
    return {"time": seconds}


def members(data: Any, voxel_size: numpy.ndarray) -> tuple[list[dict], dict]:
    """The grids of labelled data of one time as keyword arguments of Grid, and the metadata of their volume.

    `voxel_size` holds the voxel's lengths along axes without coordinates, or with one. Raises ValueError.
    """
    return _of_xarray(data, voxel_size) if _is_xarray(data) else _of_vtk(data)


def _is_xarray(data):
    return all(hasattr(data, name) for name in ("dims", "coords", "isel"))


def _of_xarray(data, voxel_size):
    time = _time_of(data)
    if time in data.dims:
        raise ValueError(f"the data have a dimension '{time}'; choose one moment, as .isel({time}=0) does")
    arrays = [data]
    if hasattr(data, "data_vars"):
        arrays = [a for a in data.data_vars.values() if _axes(a).keys() == set("xyz") and _has_lengths(a)]
    metadata = {}
    if arrays:
        grids = [_grid_of_array(array, voxel_size, metadata) for array in arrays]
    else:
        try:
            grids, metadata = _by_the_reader("dataset").grids_of(data), {"length_unit": "m"}
        except ValueError as error:  # which names options of the tool
            mend = r"data['\1'].attrs['\2'] = '\3'"
            raise ValueError(re.sub(r"--attribute '(.+?):(\w+)=(.+?)'", mend, str(error))) from None
    if time in data.coords:
        metadata |= clock(_moment(data, time))
    return grids, metadata


def _has_lengths(array):
    """Whether the coordinates along x, y and z are lengths, or have no unit."""
    units = [str(array.coords[name].attrs.get("units", "")) for name in _axes(array).values() if name in array.coords]
    return all(unit in ("", "1", "m") or _by_the_reader("units").measures(unit, "m") for unit in units)


def _by_the_reader(module):
    """A module of vdblic_convert."""
    return importlib.import_module(f"vdblic_convert.{'readers.' * (module == 'dataset')}{module}")


def _grid_of_array(array, voxel_size, metadata):
    label = "the DataArray" if array.name is None else f"'{array.name}'"
    axes = _axes(array)
    if missing := sorted(set("xyz") - axes.keys()):
        raise ValueError(f"{label} has no dimension {' and '.join(missing)}; {_about(array)}")
    rest = [dimension for dimension in array.dims if dimension not in axes.values()]
    if rest and [array.sizes[dimension] for dimension in rest] != [3]:
        sizes = ", ".join(f"{dimension} ({array.sizes[dimension]})" for dimension in rest)
        raise ValueError(f"{label} has the dimensions {sizes} beside x, y and z; a vector has one, of 3 components")
    values = array.transpose(*(axes[axis] for axis in "xyz"), *rest).values
    transform = numpy.eye(4)
    for row, axis in enumerate("xyz"):
        transform[row, row], transform[row, 3] = _step_and_first(array, axes[axis], voxel_size[row], metadata)
    missing = numpy.isnan(values) if values.dtype.kind in "fc" else numpy.zeros(values.shape, bool)
    name = array.name or ("velocity" if rest else "density")
    return {"values": values, "active": ~_any_component(missing), "transform": transform, "name": str(name)}


def _any_component(mask):
    return mask.any(axis=3) if mask.ndim == 4 else mask


def _about(data):
    return (
        f"its dimensions are {', '.join(map(str, data.dims))}; rename them to x, y and z, with coordinates in metres "
        f"{_ADVICE}"
    )


def _axes(data):
    """The dimensions along x, y and z, by the attribute `axis` of their coordinates or by their names."""
    found = {}
    for dimension in data.dims:
        for axis in _axis_of(data, dimension), str(dimension).lower():
            if axis in ("x", "y", "z"):
                found.setdefault(axis, dimension)
    return found


def _axis_of(data, name):
    return str(data.coords[name].attrs.get("axis", "")).lower() if name in data.coords else ""


def _step_and_first(array, dimension, voxel_size, metadata):
    """The distance of a dimension's coordinates, and the first. Raises ValueError if they are uneven or no lengths."""
    if dimension not in array.coords:
        return voxel_size, 0.0
    coordinates = array.coords[dimension]
    unit = str(coordinates.attrs.get("units", ""))
    stored = numpy.asarray(coordinates.values)
    if stored.dtype.kind not in "iuf" or not numpy.isfinite(stored).all():
        raise ValueError(f"the coordinates '{dimension}' are not finite numbers; give lengths")
    rounding = numpy.finfo(stored.dtype).eps if stored.dtype.kind == "f" else 0.0
    numbers = stored * 1.0
    if unit not in ("", "1"):
        numbers, metadata["length_unit"] = _converted(numbers, unit, "m", f"the coordinates '{dimension}'"), "m"
    if len(numbers) == 1:
        return voxel_size, float(numbers[0])
    first, last, count = float(numbers[0]), float(numbers[-1]), len(numbers)
    step = (last - first) / (count - 1)
    deviation = abs(numbers - numpy.linspace(first, last, count)).max()
    if step == 0 or deviation > 1e-3 * abs(step) + 2 * rounding * abs(numbers).max():
        steps = numpy.diff(numbers)
        raise ValueError(
            f"the coordinates '{dimension}' are uneven, with steps from {steps.min():g} to {steps.max():g}; "
            f"interpolate to even ones, as .interp({dimension}=numpy.linspace({stored[0]:g}, {stored[-1]:g}, {count})) "
            "does"
        )
    return step, first


def _time_of(data):
    """The dimension or the coordinate that is the time, or None."""
    for name in (*data.dims, *data.coords):
        is_time = str(name).lower() in ("time", "t", "valid_time") or _axis_of(data, name) == "t"
        if is_time or name in data.dims and name in data.coords and data.coords[name].dtype.kind in "mM":
            return name
    return None


def _moment(data, name):
    """The time of data of one time."""
    time = data.coords[name]
    unit = str(time.attrs.get("units", ""))
    if time.dtype.kind in "iuf" and unit:
        return _converted(time.values, unit, "s", f"the times '{name}'")[()]
    return time.values[()]


def _converted(values, unit, wanted, what):
    if unit == wanted:
        return values
    try:
        return _by_the_reader("units").converted(values, unit, wanted)
    except ValueError:
        raise ValueError(
            f"{what} are in '{unit}'; give them in {wanted} or what converts to it, times as xarray.decode_cf makes "
            f"them {_ADVICE}"
        ) from None


def _of_vtk(data):
    if not data.IsA("vtkImageData"):
        raise ValueError(
            f"a {data.GetClassName()} has no even voxels; resample it to a vtkImageData, as vtkResampleToImage does "
            "(vdblic_import reads files of it)"
        )
    from vtkmodules.util.numpy_support import vtk_to_numpy  # type: ignore  # pylint: disable=import-outside-toplevel

    points = numpy.array(data.GetDimensions())
    axes = numpy.array([[data.GetDirectionMatrix().GetElement(i, j) for j in range(3)] for i in range(3)])
    transform = numpy.eye(4)
    transform[:3, :3] = axes * data.GetSpacing()
    transform[:3, 3] = data.GetOrigin()
    grids = []
    for arrays, size, hidden, middle in (
        (data.GetPointData(), points, 2, 0.0),
        (data.GetCellData(), numpy.maximum(points - 1, 1), 32, numpy.where(points > 1, 0.5, 0.0)),
    ):
        place = transform.copy()
        place[:3, 3] += transform[:3, :3] @ numpy.broadcast_to(middle, 3)
        ghosts = arrays.GetArray("vtkGhostType")
        active = None if ghosts is None else _in_order(vtk_to_numpy(ghosts), size) & hidden == 0
        for array in _arrays_of(arrays):
            grids.append(
                {
                    "values": _in_order(vtk_to_numpy(array), size),
                    "active": active,
                    "transform": place,
                    "origin": tuple(data.GetExtent()[::2]),
                    "name": array.GetName() or "velocity",
                }
            )
    if not grids:
        raise ValueError("the vtkImageData has no arrays of 1 or 3 components at its points or cells")
    time = data.GetFieldData().GetArray("TimeValue")
    return grids, {} if time is None else clock(time.GetValue(0))


def _arrays_of(data):
    """Arrays of 1 or 3 components, the active vectors first."""
    arrays = [data.GetArray(index) for index in range(data.GetNumberOfArrays())]
    numbers = [array for array in arrays if array is not None and array.GetName() != "vtkGhostType"]
    fields = [array for array in numbers if array.GetNumberOfComponents() in (1, 3)]
    return sorted(fields, key=lambda array: array is not data.GetVectors())


def _in_order(values, size):
    """Values of VTK, x fastest, as an array (x, y, z[, 3])."""
    return values.reshape(*size[::-1], *values.shape[1:]).swapaxes(0, 2)
