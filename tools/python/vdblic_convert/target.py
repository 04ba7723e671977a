"""The uniform grid that a flow is resampled to: size, place and voxels."""

import dataclasses
import itertools
import typing

import numpy
from vdblic._core import memory_limit, read_box

from .errors import InputError, ParameterError

MOST_INDEX = 131072
FAR = 2.0**40  # further than any voxel
ALIGNED = 1e-3  # largest offset of voxels that count as the same [voxels]


@dataclasses.dataclass
class Target:
    """`size` voxels from index `first` on; `matrix` (4 × 4, on columns) leads from indices to world space."""

    size: tuple
    matrix: numpy.ndarray
    first: tuple = (0, 0, 0)

    bytes_of_voxel: typing.ClassVar = 80  # peak for a voxel and its coordinates while it is resampled and written
    mend: typing.ClassVar = "--size or --voxel-size"

    @classmethod
    def of_axes(cls, size, origin, spacing):
        """Voxels along the world's axes; `origin` is the centre of the first one."""
        matrix = numpy.diag([*spacing, 1.0])
        matrix[:3, 3] = origin
        return cls(tuple(map(int, size)), matrix)

    @property
    def spacing(self):
        return numpy.linalg.norm(self.matrix[:3, :3], axis=0)

    def along_axes(self):
        """Whether the voxels lie along the world's axes, unmirrored."""
        return numpy.array_equal(self.matrix[:3, :3], numpy.diag(self.spacing))

    def origin(self):
        """The centre of the first voxel in world space."""
        return self.matrix[:3, :3] @ self.first + self.matrix[:3, 3]

    def centres(self):
        """The centres of all voxels, x fastest."""
        z, y, x = numpy.meshgrid(
            *(numpy.arange(n) + f for n, f in zip(self.size[::-1], self.first[::-1])), indexing="ij"
        )
        indices = numpy.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
        return indices @ self.matrix[:3, :3].T + self.matrix[:3, 3]

    def corners(self):
        """The centres of the voxels at the eight corners."""
        ends = [(first, first + n - 1) for first, n in zip(self.first, self.size)]
        return numpy.array(list(itertools.product(*ends))) @ self.matrix[:3, :3].T + self.matrix[:3, 3]

    def covering(self, corners):
        """The same voxels and all whose centres are between corners in world space."""
        at = self._indices(corners)
        low = numpy.minimum(numpy.ceil(at.min(axis=0) - ALIGNED), self.first).astype(int)
        high = numpy.maximum(numpy.floor(at.max(axis=0) + ALIGNED), numpy.add(self.first, self.size) - 1).astype(int)
        return Target(tuple(map(int, high - low + 1)), self.matrix, tuple(map(int, low)))

    def place_of(self, other):
        """Where the voxels of another grid begin in this one, in voxels; None where they are not the same voxels."""
        at = self._indices(other.corners()) - self.first
        place = numpy.round(at[0])
        ends = numpy.array(list(itertools.product(*((0, n - 1) for n in other.size))))
        same = abs(at - place - ends).max() < ALIGNED and numpy.allclose(self.spacing, other.spacing, rtol=ALIGNED)
        return place.astype(int) if same else None

    def _indices(self, positions):
        at = (positions - self.matrix[:3, 3]) @ numpy.linalg.inv(self.matrix[:3, :3]).T
        return numpy.nan_to_num(at, nan=FAR).clip(-FAR, FAR)

    def check(self):
        """Raise ParameterError if the voxels are more than there can be."""
        if any(not 1 <= n <= MOST_INDEX for n in self.size):
            raise ParameterError(
                f"{_by(self.size)} voxels: each axis has 1 to {MOST_INDEX}; choose others with {self.mend}"
            )
        taken = self.bytes_of_voxel * float(numpy.prod(numpy.array(self.size, float)))
        there = memory_limit()
        if taken > there:
            raise ParameterError(
                f"{_by(self.size)} voxels would take {taken / 2**30:.1f} GiB of memory, and "
                f"{there / 2**30:.1f} GiB may be used; choose fewer with {self.mend}"
            )

    def __str__(self):
        return f"{_by(self.size)} voxels of {_by(self.spacing)}"


@dataclasses.dataclass
class Points(Target):
    """Places (n, 3) instead of voxels."""

    at: numpy.ndarray = None

    def centres(self):
        return self.at

    def along_axes(self):
        return False

    def place_of(self, other):
        return None


def like(reference):
    """The voxels around the active ones of a grid; `reference` is FILE or FILE:GRID."""
    return Target(**read_box(reference))


def filling(bounds, size=None, voxel_size=None):
    """Voxels that fill a box (x0, y0, z0, x1, y1, z1); `size` counts them, `voxel_size` has one or three lengths."""
    low, high = _corners(bounds)
    if voxel_size is not None:
        spacing = numpy.broadcast_to(numpy.array(voxel_size, float), 3)
        size = numpy.minimum(numpy.maximum(numpy.ceil((high - low) / spacing - 1e-6), 1), 10 * MOST_INDEX).astype(int)
    else:
        spacing = (high - low) / numpy.array(size)
    return Target.of_axes(size, low + spacing / 2, spacing)


def on_points(bounds, size):
    """Voxels whose centres are the points of an even grid from one end of a box to the other, or one in the middle."""
    low, high = _corners(bounds)
    origin = numpy.where(numpy.array(size) > 1, low, (low + high) / 2)
    return Target.of_axes(size, origin, (high - low) / numpy.maximum(numpy.array(size) - 1, 1))


def _corners(bounds):
    low, high = numpy.array(bounds[:3], float), numpy.array(bounds[3:], float)
    if not (high > low).all():
        raise InputError(f"the flow's cells are flat: they lie between {_by(low)} and {_by(high)}")
    return low, high


def _by(numbers):
    return " x ".join(f"{number:.6g}" for number in numbers)
