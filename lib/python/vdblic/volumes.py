"""Volumes of data, and of files."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping, Sequence
from typing import Any, Union

import numpy

from . import _core, layouts
from .grids import Array, Grid, Lines, Volume
from .labelled import is_labelled, members

Lengths = Union[float, Sequence[float], Array]


def read(path: str | os.PathLike) -> Volume:
    """Read a .vdb file. Grids of other types than numbers, vectors of them and streaks are left out.

    Arrays cover the box of the grid's active voxels. Raises ValueError for a file that is missing or damaged.
    """
    grids, metadata = _core.read(path_of(path))
    return volume_of(grids, metadata)


def volume_of(grids: list[Any], metadata: dict[str, Any]) -> Volume:
    """A volume of results of _core."""
    lines = next((Lines(grid) for grid in grids if isinstance(grid, _core.StoredLines)), None)
    return Volume((Grid(**grid) for grid in grids if isinstance(grid, dict)), metadata, lines)


def write(
    path: str | os.PathLike[str],
    data: Any,
    metadata: Mapping[str, Any] | None = None,
    *,
    voxel_size: Lengths = 1.0,
    layout: str | None = None,
    compression: str = "blosc",
    half: bool = False,
) -> None:
    """Write a .vdb file with checksums. It appears complete or not at all. Raises OSError if it cannot be written.

        vdblic.write("flow.vdb", {"velocity": array}, voxel_size=0.1)

    `data`, `voxel_size` and `layout` are those of as_volume(). Arrays of single precision in C order are not copied.
    `compression` is blosc or none; `half` stores numbers in half precision.
    """
    volume = as_volume(data, voxel_size=voxel_size, layout=layout)
    _core.write(
        path_of(path), as_dictionaries(volume), volume.metadata | dict(metadata or {}), compression, half
    )


def as_volume(data: Any, *, voxel_size: Lengths = 1.0, layout: str | None = None) -> Volume:
    """A volume of any data that hold fields: what advect(), Renderer, Grid and write() make of them.

    Volume, Grid   as they are; a list of Grids is a volume of them
    arrays         (x, y, z) is a grid `density`, (x, y, z, 3) a grid `velocity`, on voxels of `voxel_size`: one length
                   or three. `layout` tells another order of the axes by the letters x, y, z and c (components, last
                   unless they are named): 'zyx', 'cxyz'. Voxels with a masked value (numpy.ma) are inactive
    {name: data}   a grid of each: {"velocity": array}, {"u": u, "v": v, "w": w}
    xarray         A DataArray is one grid, of vectors if it has a further dimension of 3 components. Of a Dataset each
                   variable over x, y and z is a grid, so that u, v and w are a velocity. The dimensions are x, y and z
                   by their names or by the attribute `axis` of their coordinates, in any order. Coordinates are the
                   voxels' centres, in m, km or no unit, and even; an axis without them, or of one voxel, has
                   `voxel_size`. Missing values (NaN) are inactive. A coordinate `time` is in seconds or a date;
                   advect() takes the times of a dimension one after the other
    VTK, PyVista   Each array of 1 or 3 components of an ImageData is a grid, whose voxels' centres are the points or
                   the middles of the cells. What vtkGhostType hides is inactive. `TimeValue` of the field data is the
                   time

    >>> as_volume({"velocity": numpy.ones((5, 6, 7, 3))}, layout="zyx")
    <vdblic.Volume: velocity (7, 6, 5, 3)>

    Raises ValueError for other data, and naming what is missing or uneven.
    """
    lengths = lengths_of(voxel_size)
    layouts.checked(layout)
    if isinstance(data, Volume):
        return data
    if isinstance(data, Grid):
        return Volume([data])
    if isinstance(data, list) and data and all(isinstance(item, Grid) for item in data):
        return Volume(data)
    if is_labelled(data):
        grids, metadata = members(data, lengths)
        return Volume((Grid(**grid) for grid in grids), metadata)
    if isinstance(data, Mapping):
        return Volume(_named(name, item, lengths, layout) for name, item in data.items())
    if isinstance(data, str | os.PathLike):
        raise ValueError(f"{os.fspath(data)!r} is no field; vdblic.read() reads files")
    try:
        values = numpy.asanyarray(data)
    except ValueError:
        values = numpy.array(None)  # lists that are no array
    if values.dtype.kind not in "biuf":
        what = f"an array of {values.dtype} of the shape {values.shape}" if values.ndim else f"{data!r:.100}"
        raise ValueError(f"{what} is no field; a field is numbers (x, y, z) or (x, y, z, 3)")
    values = layouts.field(values, layout)
    name = "density" if values.ndim == 3 else "velocity"
    return Volume([Grid(values, transform=numpy.diag([*lengths, 1.0]), name=name)])


def _named(name, data, lengths, layout):
    """The grid of a name's data. Raises ValueError naming it."""
    try:
        grids = as_volume(data, voxel_size=lengths, layout=layout).grids
        if len(grids) != 1:
            raise ValueError(f"the data are several grids: {', '.join(grid.name for grid in grids)}")
    except ValueError as error:
        raise ValueError(f"'{name}': {error}") from None
    return dataclasses.replace(grids[0], name=name)


def path_of(path: str | os.PathLike) -> bytes:
    """A path as an argument of _core. Raises ValueError for a text that is no path."""
    name = os.fsencode(path)
    if b"\0" in name:
        raise ValueError(f"{path!r:.100} is no path: it holds a null character")
    return name


def lengths_of(voxel_size: Lengths) -> Array:
    """The voxel's lengths along the three axes."""
    try:
        lengths = numpy.broadcast_to(numpy.asarray(voxel_size, float), 3)
    except (TypeError, ValueError):
        lengths = numpy.zeros(3)
    if not (numpy.isfinite(lengths).all() and (lengths > 0).all()):
        raise ValueError(f"`voxel_size` cannot be {voxel_size!r}; it is one length above 0, or three")
    return lengths


def as_dictionaries(volume: Volume) -> list[Any]:
    """The grids of a volume as arguments of _core."""
    lines = [] if volume.lines is None else [volume.lines.stored]
    return [_members(grid) for grid in volume.grids] + lines


def _members(grid):
    """The members of a grid. Voxels with a masked value are inactive."""
    result = {field.name: getattr(grid, field.name) for field in dataclasses.fields(Grid)}
    result["active"] = None if grid.active is None else numpy.ma.filled(grid.active, False)
    if isinstance(grid.values, numpy.ma.MaskedArray):
        mask = numpy.ma.getmaskarray(grid.values)
        unmasked = ~(mask.any(axis=3) if mask.ndim == 4 else mask)
        result["values"] = grid.values.data
        result["active"] = unmasked if grid.active is None else result["active"] & unmasked
    return result
