"""Grids, which are arrays with a place in the world, and volumes of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy
from numpy.lib.mixins import NDArrayOperatorsMixin

from . import coordinates, views
from .labelled import is_labelled, members

Array = numpy.ndarray


@dataclasses.dataclass(repr=False, eq=False)
class Grid(NDArrayOperatorsMixin):
    """A scalar or vector field on voxels.

    It is used as the array of its values: NumPy's functions, operators, indices and `shape` are those of the array, and
    what is computed is a plain array.

    >>> grid = Grid(numpy.zeros((4, 3, 2)), name="speed")
    >>> grid
    <vdblic.Grid 'speed' (x: 4, y: 3, z: 2) float64, voxel size 1>
    >>> grid[:, :, 1].shape, numpy.cos(grid).shape, float((grid + 1).sum())
    ((4, 3), (4, 3, 2), 24.0)
    """

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
    metadata: dict[str, Any] = dataclasses.field(default_factory=dict)
    """Texts, numbers, truth values and tuples of 2 to 4 numbers. A number of Python is stored in 64 bits, one of NumPy
    in its own type, whole numbers of tuples in 32 bits. read() gives what write() stores in the file's types."""
    staggered: bool = False
    """Whether the components of a vector lie on the faces of its voxel, half a voxel below its centre."""

    def __post_init__(self) -> None:
        if is_labelled(self.values):
            self._take(*members(self.values, numpy.ones(3))[0])
        if self.transform is None:
            self.transform = numpy.eye(4)

    def _take(self, first: dict[str, Any], *more: dict[str, Any]) -> None:
        """Fill in from labelled data whatever is not given."""
        if more:
            names = ", ".join(grid["name"] for grid in (first, *more))
            raise ValueError(f"`values` are several grids: {names}; as_volume() takes them all")
        self.values = first["values"]
        if self.active is None:
            self.active = first["active"]
        if self.transform is None:
            self.transform, self.origin = first["transform"], first.get("origin", self.origin)

    @property
    def shape(self) -> tuple[int, ...]:
        """(x, y, z), or (x, y, z, 3) for vectors."""
        return numpy.shape(self.values)

    @property
    def ndim(self) -> int:
        """3, or 4 for vectors."""
        return numpy.ndim(self.values)

    @property
    def dtype(self) -> numpy.dtype[Any]:
        """The type of the values."""
        return numpy.asanyarray(self.values).dtype

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, index: Any) -> Any:
        return self.values[index]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        values = numpy.asarray(self.values)
        if copy or dtype is not None and values.dtype != dtype:
            if copy is False:  # as NumPy 2 asks for it
                raise ValueError(f"the grid '{self.name}' holds {values.dtype}; as {numpy.dtype(dtype)} it is a copy")
            return numpy.array(values, dtype)
        return values

    def __array_ufunc__(self, function: numpy.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        arrays = (item.values if isinstance(item, Grid) else item for item in inputs)
        return getattr(function, method)(*arrays, **options)

    def __repr__(self) -> str:
        sides = ", ".join(f"{axis}: {length}" for axis, length in zip("xyz", self.shape))
        vector = ", 3" if self.ndim == 4 else ""
        size = ", ".join(f"{length:.6g}" for length in dict.fromkeys(self.voxel_size))
        return f"<vdblic.Grid '{self.name}' ({sides}{vector}) {self.dtype}, voxel size {size}>"

    def _repr_html_(self) -> str:
        return views.slices(self, repr(self))

    def positions(self) -> Array:
        """The world positions of the voxels' centres, (x, y, z, 3)."""
        indices = numpy.stack(tuple(numpy.indices(self.shape[:3])), axis=-1) + self.origin
        return indices @ self.transform[:3, :3].T + self.transform[:3, 3]

    @property
    def voxel_size(self) -> Array:
        """The voxel's lengths along its axes, in world units."""
        return numpy.linalg.norm(self.transform[:3, :3], axis=0)

    def to_xarray(self) -> Any:
        """A DataArray on x, y and z, the centres of the voxels, with `component` for vectors. Inactive voxels are NaN.

        Units are those of the metadata `unit` and `length_unit`; a `time` is a coordinate. Raises ValueError where no
        such coordinates exist: on turned axes, and for staggered grids.
        """
        return coordinates.data_array(self, self.metadata)


class Volume(Mapping[str, Grid]):
    """Grids by name, and the metadata of their file. Several grids of one name: the first.

    >>> volume = Volume([Grid(numpy.zeros((4, 3, 2)), name="speed")], {"frame": 7})
    >>> volume
    <vdblic.Volume: speed (4, 3, 2); frame 7>
    >>> list(volume), volume["speed"].shape
    (['speed'], (4, 3, 2))
    """

    def __init__(self, grids: Iterable[Grid], metadata: Mapping[str, Any] | None = None):
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

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)

    def __repr__(self) -> str:
        shapes = ", ".join(f"{grid.name} {grid.shape}" for grid in self.grids) or "no grids"
        frame = "" if self.frame is None else f"; frame {self.frame}"
        time = "" if self.time is None else f"; time {self.time:.6g} s"
        return f"<vdblic.Volume: {shapes}{frame}{time}>"

    def _repr_html_(self) -> str:
        return views.heading(repr(self)) + "".join(grid._repr_html_() for grid in self.grids)

    @property
    def frame(self) -> int | None:
        """The number of the frame, if the file has one."""
        return self._of_file_or_grid("frame")

    @property
    def time(self) -> float | None:
        """The time in seconds, if the file has one."""
        return self._of_file_or_grid("time")

    def _of_file_or_grid(self, key: str) -> Any:
        return next((data[key] for data in (self.metadata, *(g.metadata for g in self.grids)) if key in data), None)

    def to_xarray(self) -> Any:
        """A Dataset of the grids, as Grid.to_xarray() makes them. Raises ValueError if their voxels differ."""
        return coordinates.dataset(self.grids, self.metadata)
