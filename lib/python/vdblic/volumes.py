"""Volumes: grids as arrays, and their files."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterable, Iterator, Mapping

import numpy
import numpy.typing

from . import _core

Array = numpy.ndarray


@dataclasses.dataclass
class Grid:
    """A scalar or vector field on voxels."""

    values: Array
    """(x, y, z), or (x, y, z, 3) for vectors; single precision is stored."""
    active: Array | None = None
    """(x, y, z): the voxels that have a value; None for all."""
    transform: Array = dataclasses.field(default_factory=lambda: numpy.eye(4))
    """4 × 4: voxel index (i, j, k, 1) to world space. Voxel centres are at whole indices."""
    origin: tuple[int, int, int] = (0, 0, 0)
    """Index of the voxel values[0, 0, 0]."""
    name: str = "density"
    metadata: dict = dataclasses.field(default_factory=dict)
    staggered: bool = False
    """Whether the components of a vector lie on the faces of its voxel, half a voxel below its centre."""

    def positions(self) -> Array:
        """The world positions of the voxels' centres, (x, y, z, 3)."""
        indices = numpy.stack(numpy.indices(self.values.shape[:3]), axis=-1) + self.origin
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
    grids, metadata = _core.read(os.fspath(path))
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

    Arrays of single precision in C order are not copied. `compression` is blosc, zip or none; `half` stores numbers in
    half precision.
    """
    if isinstance(grids, Volume):
        metadata = {**grids.metadata, **(metadata or {})}
    dictionaries = as_dictionaries([grids] if isinstance(grids, Grid) else getattr(grids, "grids", grids))
    _core.write(os.fspath(path), dictionaries, dict(metadata or {}), compression, half)


def as_dictionaries(grids: Iterable[Grid]) -> list[dict]:
    """Grids as the library's side takes them."""
    return [{field.name: getattr(grid, field.name) for field in dataclasses.fields(Grid)} for grid in grids]
