"""Volumes: grids as arrays, and their files."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy

from . import _core
from .labelled import is_labelled, members

Array = numpy.ndarray


@dataclasses.dataclass(repr=False)
class Grid:
    """A scalar or vector field on voxels."""

    values: Array
    """(x, y, z), or (x, y, z, 3) for vectors; single precision is stored. Voxels with a masked value (numpy.ma) are
    inactive. A DataArray of xarray or an image of VTK with one array gives the transform too (as_volume())."""
    active: Array | None = None
    """(x, y, z): the voxels that have a value; None for all."""
    transform: Array = None  # type: ignore[assignment]
    """4 × 4: voxel index (i, j, k, 1) to world space. Voxel centres are at whole indices. By default of length 1."""
    origin: tuple[int, int, int] = (0, 0, 0)
    """Index of the voxel values[0, 0, 0]."""
    name: str = "density"
    metadata: dict = dataclasses.field(default_factory=dict)
    """Texts, numbers, truth values and tuples of 2 to 4 numbers. A number of Python is stored in 64 bits, one of NumPy
    in its own type, whole numbers of tuples in 32 bits. read() gives what write() stores in the file's types."""
    staggered: bool = False
    """Whether the components of a vector lie on the faces of its voxel, half a voxel below its centre."""

    def __post_init__(self) -> None:
        if is_labelled(self.values):
            self._take(*members(self.values, numpy.ones(3))[0])
        if self.transform is None:
            self.transform = numpy.eye(4)

    def _take(self, first: dict, *more: dict) -> None:
        """Fill in from labelled data whatever is not given."""
        if more:
            names = ", ".join(grid["name"] for grid in (first, *more))
            raise ValueError(f"`values` are several grids: {names}; as_volume() takes them all")
        self.values = first["values"]
        if self.active is None:
            self.active = first["active"]
        if self.transform is None:
            self.transform, self.origin = first["transform"], first.get("origin", self.origin)

    def __repr__(self) -> str:
        shape = numpy.shape(self.values)
        sides = ", ".join(f"{axis}: {length}" for axis, length in zip("xyz", shape))
        vector = ", 3" if len(shape) == 4 else ""
        size = ", ".join(f"{length:.6g}" for length in dict.fromkeys(self.voxel_size))
        return f"<vdblic.Grid '{self.name}' ({sides}{vector}) {numpy.asarray(self.values).dtype}, voxel size {size}>"

    def positions(self) -> Array:
        """The world positions of the voxels' centres, (x, y, z, 3)."""
        indices = numpy.stack(tuple(numpy.indices(self.values.shape[:3])), axis=-1) + self.origin
        return indices @ self.transform[:3, :3].T + self.transform[:3, 3]

    @property
    def voxel_size(self) -> Array:
        """The voxel's lengths along its axes, in world units."""
        return numpy.linalg.norm(self.transform[:3, :3], axis=0)


class Volume(Mapping[str, Grid]):
    """Grids by name, and the metadata of their file. Several grids of one name: the first."""

    def __init__(self, grids: Iterable[Grid], metadata: Mapping | None = None):
        self.grids = list(grids)
        self.metadata = dict(metadata or {})

    def __getitem__(self, name: str) -> Grid:
        for grid in self.grids:
            if grid.name == name:
                return grid
        raise KeyError(f"no grid '{name}'; the volume holds {', '.join(grid.name for grid in self.grids) or 'none'}")

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys(grid.name for grid in self.grids))

    def __len__(self) -> int:
        return len({grid.name for grid in self.grids})

    def __repr__(self) -> str:
        shapes = ", ".join(f"{grid.name} {grid.values.shape}" for grid in self.grids)
        return f"Volume({shapes})"

    @property
    def frame(self) -> int | None:
        """The number of the frame, if the file has one."""
        return self._of_file_or_grid("frame")

    @property
    def time(self) -> float | None:
        """The time in seconds, if the file has one."""
        return self._of_file_or_grid("time")

    def _of_file_or_grid(self, key):
        return next((data[key] for data in (self.metadata, *(g.metadata for g in self.grids)) if key in data), None)


def read(path: str | os.PathLike) -> Volume:
    """Read a .vdb file. Grids of other types than floats, doubles and vectors of them are left out.

    Arrays cover the box of the grid's active voxels. Raises ValueError for a file that is missing or damaged.
    """
    grids, metadata = _core.read(path_of(path))
    return Volume((Grid(**grid) for grid in grids), metadata)


def write(
    path: str | os.PathLike,
    grids: Volume | Grid | Iterable[Grid],
    metadata: Mapping | None = None,
    *,
    compression: str = "blosc",
    half: bool = False,
) -> None:
    """Write a .vdb file with checksums. It appears complete or not at all. Raises OSError if it cannot be written.

    Arrays of single precision in C order are not copied. `compression` is blosc or none; `half` stores numbers in half
    precision.
    """
    volume = grids if isinstance(grids, Volume) else Volume([grids] if isinstance(grids, Grid) else grids)
    _core.write(
        path_of(path), as_dictionaries(volume.grids), volume.metadata | dict(metadata or {}), compression, half
    )


def as_volume(data: Any, *, voxel_size: float | Sequence[float] = 1.0) -> Volume:
    """A volume of any data that hold fields: what advect(), Renderer and Grid make of them.

    Volume, Grid   as they are
    arrays         (x, y, z) is a grid `density`, (x, y, z, 3) a grid `velocity`, on voxels of `voxel_size`: one length
                   or three. Voxels with a masked value (numpy.ma) are inactive
    xarray         A DataArray is one grid, of vectors if it has a further dimension of 3 components. Of a Dataset each
                   variable over x, y and z is a grid, so that u, v and w are a velocity. The dimensions are x, y and z
                   by their names or by the attribute `axis` of their coordinates, in any order. Coordinates are the
                   voxels' centres, in m, km or no unit, and even; an axis without them, or of one voxel, has
                   `voxel_size`. Missing values (NaN) are inactive. A coordinate `time` is in seconds or a date;
                   advect() takes the times of a dimension one after the other
    VTK, PyVista   Each array of 1 or 3 components of an ImageData is a grid, whose voxels' centres are the points or
                   the middles of the cells. What vtkGhostType hides is inactive. `TimeValue` of the field data is the
                   time

    Raises ValueError for other data, and naming what is missing or uneven.
    """
    lengths = lengths_of(voxel_size)
    if isinstance(data, Volume):
        return data
    if isinstance(data, Grid):
        return Volume([data])
    if is_labelled(data):
        grids, metadata = members(data, lengths)
        return Volume((Grid(**grid) for grid in grids), metadata)
    try:
        values = numpy.asanyarray(data)
    except ValueError:
        values = numpy.array(None)  # lists that are no array
    if not (values.ndim == 3 or values.ndim == 4 and values.shape[3] == 3) or values.dtype.kind not in "biuf":
        what = f"an array of {values.dtype} of the shape {values.shape}" if values.ndim else f"{data!r:.100}"
        raise ValueError(f"{what} is no field; a field is numbers (x, y, z) or (x, y, z, 3)")
    name = "density" if values.ndim == 3 else "velocity"
    return Volume([Grid(values, transform=numpy.diag([*lengths, 1.0]), name=name)])


def path_of(path: str | os.PathLike) -> bytes:
    """A path as the library's side takes it. Raises ValueError for a text that can be none."""
    name = os.fsencode(path)
    if b"\0" in name:
        raise ValueError(f"{path!r:.100} is no path: it holds a null character")
    return name


def lengths_of(voxel_size: float | Sequence[float]) -> Array:
    """The voxel's lengths along the three axes."""
    try:
        lengths = numpy.broadcast_to(numpy.asarray(voxel_size, float), 3)
    except (TypeError, ValueError):
        lengths = numpy.zeros(3)
    if not (numpy.isfinite(lengths).all() and (lengths > 0).all()):
        raise ValueError(f"`voxel_size` cannot be {voxel_size!r}; it is one length above 0, or three")
    return lengths


def as_dictionaries(grids: Iterable[Grid]) -> list[dict]:
    """Grids as the library's side takes them."""
    return [_members(grid) for grid in grids]


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
