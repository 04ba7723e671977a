"""The uniform grid that a flow is resampled to: size, place and voxels."""

import dataclasses

import numpy
from vdblic._core import memory_limit, read_box

from .errors import InputError, ParameterError

MOST_INDEX = 131072
BYTES = 80  # taken by a voxel and its coordinates while it is resampled and written


@dataclasses.dataclass
class Target:
    """`size` voxels from index `first` on; `matrix` (4 × 4, on columns) leads from indices to world space."""

    size: tuple
    matrix: numpy.ndarray
    first: tuple = (0, 0, 0)

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

    def flattened(self):
        """One layer of voxels in the place of two layers of points, which are its faces."""
        matrix = self.matrix.copy()
        matrix[:3, 3] += matrix[:3, 2] / 2
        return Target((*self.size[:2], 1), matrix, self.first)

    def centres(self):
        """The centres of all voxels, x fastest."""
        z, y, x = numpy.meshgrid(
            *(numpy.arange(n) + f for n, f in zip(self.size[::-1], self.first[::-1])), indexing="ij"
        )
        indices = numpy.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
        return indices @ self.matrix[:3, :3].T + self.matrix[:3, 3]

    def check(self):
        """Raise ParameterError if the voxels are more than there can be."""
        if any(not 1 <= n <= MOST_INDEX for n in self.size):
            raise ParameterError(
                f"{_by(self.size)} voxels: each axis has 1 to {MOST_INDEX}; choose others with --size or --voxel-size"
            )
        taken = BYTES * float(numpy.prod(numpy.array(self.size, float)))
        there = memory_limit()
        if taken > there:
            raise ParameterError(
                f"{_by(self.size)} voxels would take {taken / 2**30:.1f} GiB of memory, and "
                f"{there / 2**30:.1f} GiB may be used; choose fewer with --size or --voxel-size"
            )

    def __str__(self):
        return f"{_by(self.size)} voxels of {_by(self.spacing)}"


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
    """Voxels whose centres are the points of an even grid from one end of a box to the other."""
    low, high = _corners(bounds)
    return Target.of_axes(size, low, (high - low) / (numpy.array(size) - 1))


def _corners(bounds):
    low, high = numpy.array(bounds[:3], float), numpy.array(bounds[3:], float)
    if not (high > low).all():
        raise InputError(f"the flow's cells are flat: they lie between {_by(low)} and {_by(high)}")
    return low, high


def _by(numbers):
    return " x ".join(f"{number:.6g}" for number in numbers)
