"""The grids of a volume as dense arrays over one box of voxels."""

import dataclasses
import os

import numpy

from .errors import InputError
from .target import matrix_of
from .velocity import contents
from .volumes import metadata_of, read_volume

KINDS = ("float", "double", "vec3s", "vec3d")
MARK = float(numpy.finfo(numpy.float32).max)  # what no value is


@dataclasses.dataclass
class Dense:
    """Arrays (x, y, z[, 3]) by grid name, the active voxels, the way from indices to world space, metadata."""

    arrays: dict
    active: numpy.ndarray
    matrix: numpy.ndarray
    metadata: dict


def read_dense(path, names, console):
    """The named grids of a file, or all of numbers and vectors, at the voxels of its texture or of the first one.

    Grids of other voxels are interpolated there. Raises InputError.
    """
    grids, metadata = read_volume(path)
    found = {grid.name: grid for grid in grids if grid.valueTypeName in KINDS}
    for name in names:
        if name not in found:
            known = contents({grid.name: 3 if "vec" in grid.valueTypeName else 1 for grid in found.values()})
            raise InputError(f"{path}: no grid '{name}' of numbers or vectors; the file holds {known}")
    chosen = {name: found[name] for name in names or found}
    if not chosen:
        raise InputError(f"{path}: the file holds no grids of numbers or vectors")
    reference = chosen.get(metadata.get("texture")) or next(iter(chosen.values()))
    low, high = reference.evalActiveVoxelBoundingBox()
    if reference.activeVoxelCount() == 0:
        console.warn(f"{path}: grid '{reference.name}' has no active voxels")
        low = high = (0, 0, 0)
    size = [b - a + 1 for a, b in zip(low, high)]
    _check_memory(path, size, sum(12 if "vec" in grid.valueTypeName else 4 for grid in chosen.values()))
    matrix = matrix_of(reference.transform)
    matrix[:3, 3] += matrix[:3, :3] @ low
    arrays = {}
    for name, grid in chosen.items():
        other = matrix_of(grid.transform)
        if numpy.allclose(other, matrix_of(reference.transform), rtol=1e-12, atol=1e-12 * abs(other).max()):
            values, active = _box(grid, low, size)
            arrays[name] = values
            if grid is reference:
                mask = active
        else:
            arrays[name] = _interpolated(grid, numpy.linalg.inv(other) @ matrix, size, path)
            console.detail(f"{path}: grid '{name}' is interpolated at the voxels of '{reference.name}'")
    return Dense(arrays, mask, matrix, metadata | metadata_of(path))


def _check_memory(path, size, value_bytes):
    taken = 3.0 * value_bytes * numpy.prod(numpy.array(size, float))
    there = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if taken > there:
        raise InputError(
            f"{path}: the box around {' x '.join(map(str, size))} voxels would take {taken / 2**30:.1f} GiB of memory,"
            f" the machine has {there / 2**30:.1f} GiB"
        )


def _box(grid, low, size):
    """A grid's values and active voxels over a box. Components on faces are averaged to the centres."""
    staggered = grid.gridClass == "staggered" and "vec" in grid.valueTypeName
    wide = [n + staggered for n in size]
    values, active = _copied(grid, low, wide)
    if staggered:
        inside = tuple(slice(n) for n in size)
        centred = values[inside].copy()
        for axis in range(3):
            above = tuple(slice(1, n + 1) if i == axis else slice(n) for i, n in enumerate(size))
            there = active[above]  # the nearer face stands for both where the other is missing
            centred[..., axis] += numpy.where(there, (values[above][..., axis] - centred[..., axis]) / 2, 0)
        values, active = centred, active[inside]
    return values, active


def _copied(grid, low, size):
    vector = "vec" in grid.valueTypeName
    shape = (*size, 3) if vector else tuple(size)
    values = numpy.zeros(shape, numpy.float32)
    marked = numpy.zeros(shape, numpy.float32)
    grid.copyToArray(values, low)
    background, grid.background = grid.background, (MARK,) * 3 if vector else MARK
    grid.copyToArray(marked, low)
    grid.background = background
    active = marked != numpy.float32(MARK)
    active = active.any(axis=3) if vector else active
    if active.sum() > grid.activeVoxelCount():  # inactive voxels of other values than the background
        for off in grid.citerOffValues():
            first = [max(a - b, 0) for a, b in zip(off.min, low)]
            last = [min(a - b + 1, n) for a, b, n in zip(off.max, low, size)]
            if all(a < b for a, b in zip(first, last)):
                active[tuple(slice(a, b) for a, b in zip(first, last))] = False
    return values, active


def _interpolated(grid, matrix, size, path):
    """A grid's values, linearly interpolated between its active voxels; `matrix` leads from voxels to its indices."""
    scale = numpy.diag(matrix)[:3]
    if not numpy.allclose(matrix[:3, :3], numpy.diag(scale), atol=1e-6 * abs(scale).max()):
        raise InputError(f"{path}: grid '{grid.name}' is turned against the others; export it by itself with --grids")
    low, high = grid.evalActiveVoxelBoundingBox()
    box = [b - a + 1 for a, b in zip(low, high)]
    values, active = _box(grid, low, box)
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
