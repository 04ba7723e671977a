"""The grids of a volume as dense arrays over one box of voxels."""

import dataclasses

import numpy
from vdblic._core import read_over_one_box

from .errors import InputError


@dataclasses.dataclass
class Dense:
    """Arrays (x, y, z[, 3]) by grid name, the active voxels, the way from indices to world space, metadata."""

    arrays: dict
    active: numpy.ndarray
    matrix: numpy.ndarray
    metadata: dict

    @property
    def is_sparse(self):
        """Whether inactive voxels of the texture are empty."""
        return self.metadata.get("inactive") == "empty"


def read_dense(path, names, console):
    """The named grids of a file, or all of numbers and vectors, at the voxels of its texture or of the first one.

    Grids of other voxels are interpolated there. Raises InputError.
    """
    grids, metadata = read_over_one_box(path, names)
    reference = grids[0]
    if not reference["active"].any():
        console.warn(f"{path}: grid '{reference['name']}' has no active voxels")
    matrix, arrays = reference["transform"].copy(), {}
    matrix[:3, 3] += matrix[:3, :3] @ reference["origin"]
    for grid in grids:
        values, active = _centred(grid) if grid["staggered"] else (grid["values"], grid["active"])
        if grid is reference:
            mask = active
        elif not grid["alike"]:
            values = _interpolated(grid, values, active, matrix, mask.shape, path)
            console.detail(f"{path}: grid '{grid['name']}' is interpolated at the voxels of '{reference['name']}'")
        arrays[grid["name"]] = values
    return Dense(arrays, mask, matrix, metadata)


def _centred(grid):
    """Values at the centres of voxels, and the active ones: means of components on the faces below and above."""
    values, active = grid["values"], grid["active"]
    inside = (slice(-1),) * 3
    centred = values[inside].copy()
    for axis in range(3):
        above = (*inside[:axis], slice(1, None), *inside[axis + 1 :])
        there = active[above]  # the nearer face stands for both where the other is missing
        centred[..., axis] += numpy.where(there, (values[above][..., axis] - centred[..., axis]) / 2, 0)
    return centred, active[inside]


def _interpolated(grid, values, active, matrix, size, path):
    """Values of a grid, linearly interpolated between its active voxels; `matrix` leads from voxels to world space."""
    try:
        matrix = numpy.linalg.inv(grid["transform"]) @ matrix
    except numpy.linalg.LinAlgError:
        raise InputError(f"{path}: grid '{grid['name']}' has a transform that flattens space") from None
    scale = numpy.diag(matrix)[:3]
    if not numpy.allclose(matrix[:3, :3], numpy.diag(scale), atol=1e-6 * abs(scale).max()):
        raise InputError(
            f"{path}: grid '{grid['name']}' is turned against the others; export it by itself with --grids"
        )
    low, box = grid["origin"], active.shape
    vector = values.ndim == 4
    values = values if vector else values[..., None]
    values, weights = values * active[..., None], active.astype(numpy.float32)[..., None]
    for axis, n in enumerate(size):
        at = numpy.clip(matrix[axis, 3] - low[axis] + scale[axis] * numpy.arange(n), 0, box[axis] - 1)
        first = numpy.minimum(at.astype(int), max(box[axis] - 2, 0))
        share = (at - first).astype(numpy.float32).reshape([-1 if i == axis else 1 for i in range(4)])
        second = numpy.minimum(first + 1, box[axis] - 1)
        values, weights = (
            numpy.take(part, first, axis) * (1 - share) + numpy.take(part, second, axis) * share
            for part in (values, weights)
        )
    values = numpy.where(weights > 0, values / numpy.maximum(weights, 1e-30), 0)
    return values if vector else values[..., 0]
