"""Grids, which are arrays with a place in the world, and volumes of them."""

from __future__ import annotations

import dataclasses
import functools
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

    It is used as the array of its values: NumPy's functions, operators, indices and `shape` are the array's, and
    results are plain arrays.

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


def _array(name, doc):
    return property(lambda self: self._arrays[name], doc=doc)


class Lines:
    """Streaks as lines, `lines` of a Volume: a Renderer draws them, write() stores them. Their arrays are to be read.

    It is a sequence of lines, each an array (points, 3) of places in world space, from the end of the tail to the head.
    """

    def __init__(self, stored: Any) -> None:
        self.stored = stored

    @functools.cached_property
    def _arrays(self) -> dict[str, Any]:
        arrays: dict[str, Any] = self.stored.arrays()
        for array in (*arrays.values(), *arrays["scalars"].values()):
            if isinstance(array, numpy.ndarray):
                array.flags.writeable = False  # a change would not be drawn
        return arrays

    ids = _array("id", "Of each line its number, the same in all frames.")
    counts = _array("counts", "Of each line the number of its points.")
    source = _array("source", "Of each line the number of the source that it was in; 0 for none.")
    points = _array("points", "(points, 3): the places of all lines' points, in world space.")
    radius = _array("radius", "Of each point that of the tube, in world units.")
    opacity = _array("opacity", "Of each point 0 to 1, highest at the head.")
    age = _array("age", "Of each point the frames since the particle was there.")
    scalars = _array("scalars", "Arrays by name, of each point: `magnitude`, the speed, and others that were asked for.")

    @functools.cached_property
    def _ends(self) -> Array:
        return numpy.cumsum(self.counts)

    def __len__(self) -> int:
        return len(self.counts)

    def __getitem__(self, index: int) -> Array:
        end = self._ends[index]
        return self.points[end - self.counts[index] : end]  # type: ignore[no-any-return]

    def __iter__(self) -> Iterator[Array]:
        return map(self.__getitem__, range(len(self)))

    def __repr__(self) -> str:
        return f"<vdblic.Lines: {len(self)} lines, {len(self.points)} points>"


class Volume(Mapping[str, Grid]):
    """Grids by name, and the metadata of their file. Several grids of one name: the first.

    >>> volume = Volume([Grid(numpy.zeros((4, 3, 2)), name="speed")], {"frame": 7})
    >>> volume
    <vdblic.Volume: speed (4, 3, 2); frame 7>
    >>> list(volume), volume["speed"].shape
    (['speed'], (4, 3, 2))
    """

    def __init__(
        self, grids: Iterable[Grid], metadata: Mapping[str, Any] | None = None, lines: Lines | None = None
    ) -> None:
        self.grids = list(grids)
        self.metadata = dict(metadata or {})
        self.lines: Any = lines
        """The Lines of streaks; None if there are none."""

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
        lines = "" if self.lines is None else f"; {len(self.lines)} lines"
        return f"<vdblic.Volume: {shapes}{lines}{frame}{time}>"

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
