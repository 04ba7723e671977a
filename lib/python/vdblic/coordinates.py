"""Grids as data of xarray, which is imported when they are asked for."""

from __future__ import annotations

from typing import Any

import numpy


def data_array(grid: Any, metadata: dict) -> Any:
    """A grid as a DataArray. @param metadata of the grid, or of its file where the grid has none"""
    import xarray  # pylint: disable=import-outside-toplevel

    if grid.staggered:
        raise ValueError(f"the grid '{grid.name}' is staggered: its components have no common coordinates")
    axes = numpy.asarray(grid.transform, float)
    if numpy.count_nonzero(axes[:3, :3] - numpy.diag(numpy.diag(axes[:3, :3]))):
        raise ValueError(
            f"the axes of the grid '{grid.name}' are turned, so x, y and z are no coordinates of them; positions() "
            "tells where the voxels are"
        )
    metadata = metadata | grid.metadata
    unit = {"units": metadata["length_unit"]} if metadata.get("length_unit") else {}
    places: dict[str, Any] = {}
    for row, axis in enumerate("xyz"):
        indices = grid.origin[row] + numpy.arange(grid.shape[row])
        places[axis] = axis, indices * axes[row, row] + axes[row, 3], {"axis": axis.upper(), **unit}
    if "time" in metadata:
        places["time"] = _time(metadata)
    is_vector = grid.ndim == 4
    return xarray.DataArray(
        _with_gaps(grid), places, ("x", "y", "z", *["component"] * is_vector), grid.name,
        {"units": grid.metadata["unit"]} if grid.metadata.get("unit") else {},
    )  # fmt: skip


def _with_gaps(grid):
    """The values, NaN in inactive voxels."""
    mask = numpy.ma.getmaskarray(grid.values)
    gaps = mask.any(axis=3) if grid.ndim == 4 else mask
    if grid.active is not None:
        gaps = gaps | ~numpy.ma.filled(grid.active, False).astype(bool)
    values = numpy.asarray(grid.values)
    if not gaps.any():
        return values
    values = values.astype(numpy.promote_types(values.dtype, numpy.float32))
    values[gaps] = numpy.nan
    return values


def _time(metadata):
    """The time as a coordinate: a date if the first date is known."""
    if "start" not in metadata:
        return (), metadata["time"], {"units": "s"}
    passed = numpy.timedelta64(round(metadata["time"] * 1e9), "ns")
    return (), numpy.datetime64(metadata["start"], "ns") + passed


def dataset(grids: list, metadata: dict) -> Any:
    """Grids as a Dataset, which they share the voxels of."""
    import xarray  # pylint: disable=import-outside-toplevel

    for grid in grids[1:]:
        if not numpy.array_equal(grid.transform, grids[0].transform):
            raise ValueError(
                f"the voxels of '{grids[0].name}' and '{grid.name}' differ: take the grids one by one, or textures with "
                'scalars="texture"'
            )
    named: dict[str, Any] = {}
    for grid in grids:
        named.setdefault(grid.name, grid)
    return xarray.Dataset({name: data_array(grid, metadata) for name, grid in named.items()})
