"""Coarser copies of volumes, for viewports: each level has half the voxels of the one before along each axis."""

import re

import numpy
from vdblic._core import FramePattern, Sequence, check_not_input, check_output_pattern, is_finished, read, write

from .errors import InputError, ParameterError
from .outputs import check_not_inputs
from .tool import whole
from .velocity import names_of

MOST_LEVELS = 8
_FIELD = re.compile(r"%0?\d*d|\$F\d*|<F\d+>|#+|@+")
_LEAST_HALF, _MOST_HALF = 1 / 16, 65504  # largest magnitudes that half precision holds well


def add_options(tool):
    tool.add(
        "--levels",
        metavar=f"INT:INT in [1 - {MOST_LEVELS}]",
        type=whole(1, MOST_LEVELS),
        help="Write coarser copies, level 1 with voxels of twice the size and so on: lic.level1.%%04d.vdb of -o "
        "lic.%%04d.vdb; with a .usda the coarsest one is its proxy.",
    )


def level_pattern(text, level):
    """The pattern of a level's files: `level1.` stands before the frame field, or `.level1` before the extension."""
    folder, slash, name = text.rpartition("/")
    field = _FIELD.search(name)
    at = field.start() if field else name.lower().rindex(".vdb")
    word = f"level{level}." if field else f".level{level}"
    return f"{folder}{slash}{name[:at]}{word}{name[at:]}"


class Levels:
    """The files of all levels of a sequence. @param text  pattern of the names, without the level"""

    def __init__(self, text, count, grids, skip):
        self.patterns = [FramePattern(level_pattern(text, level + 1)) for level in range(count)]
        self._names, self._skip, self._done = names_of(grids) if grids else (), skip, 0

    def check(self, frames, inputs):
        for pattern in self.patterns:
            check_output_pattern(pattern, len(frames))
            check_not_inputs(map(pattern.path, frames), inputs)

    def write(self, frame, source, console):
        """Write the levels of a file; returns their paths."""
        paths = [pattern.path(frame) for pattern in self.patterns]
        self._done += 1
        for pattern, path in zip(self.patterns, paths):
            check_output_pattern(pattern, self._done)
            check_not_input(path, source)
        if not (self._skip and all(map(is_finished, paths))):
            grids, metadata = read(str(source))
            grids = self._chosen(source, grids)
            sparse = metadata.get("texture", "density") if metadata.get("inactive") == "empty" else None
            for level, path in enumerate(paths):
                grids = [coarser(grid, grid["name"] == sparse) for grid in grids]
                half = all(_suits_half(grid["values"]) for grid in grids)
                write(str(path), grids, metadata | {"level": numpy.int32(level + 1)}, "blosc", half)
        for path in paths:
            console.finished(path)
        return paths

    def _chosen(self, source, grids):
        there = {grid["name"]: grid for grid in reversed(grids)}
        for name in self._names:
            if name not in there:
                raise InputError(f"{source}: no grid '{name}' of numbers; present: {', '.join(there)}")
        chosen = [there[name] for name in self._names] if self._names else grids
        if not chosen:
            raise InputError(f"{source}: no grid of numbers to make coarser")
        return chosen


def export_levels(options, console, stop):
    """Write the levels of every selected frame."""
    if not options.levels:
        raise ParameterError(f"{options.output}: a .vdb would be a copy; --levels writes coarser ones")
    levels = Levels(options.output, options.levels, options.grids, options.skip_existing)
    files = Sequence(options.input, options.frames, options.clamp_frames, options.renumber, stop.check)
    if options.input != "-":
        files = list(files)
        levels.check([frame for frame, _ in files], [path for _, path in files])
    done = 0
    for frame, source in files:
        stop.check()
        levels.write(frame, source, console)
        done += 1
        console.progress(frame, done, len(files) if options.input != "-" else 0)
    if not done:
        raise InputError("standard input names no files")


def coarser(grid, counts_empty=False):
    """A grid with half the voxels along each axis: means of the active ones among eight.

    Voxel c stands for the voxels 2c and 2c + 1 of the finer grid along each axis, so its centre is 2c + 1/2 there.
    Components on the faces of staggered voxels are means over the four finer faces that make a coarser one.
    @param counts_empty  inactive voxels count as the 0 that they are (streaks), so that optical depth stays
    """
    values, active = grid["values"], grid["active"]
    vector = values.ndim == 4
    low = numpy.array(grid["origin"]) // 2
    size = -(-(numpy.array(grid["origin"]) + active.shape) // 2) - low
    before = numpy.array(grid["origin"]) - 2 * low
    pad = [(int(b), int(2 * n - b - s)) for b, n, s in zip(before, size, active.shape)]
    active = numpy.pad(active, pad)
    values = numpy.pad(values, [*pad, (0, 0)] if vector else pad)
    values = values if vector else values[..., None]
    sums = [
        _means(values[..., i], active, i if grid["staggered"] else None, counts_empty) for i in range(values.shape[3])
    ]
    result = numpy.stack([mean for mean, _ in sums], axis=-1)
    there = numpy.logical_or.reduce([seen for _, seen in sums])
    matrix = numpy.array(grid["transform"])
    matrix[:3, 3] += matrix[:3, :3] @ numpy.full(3, 0.5)
    matrix[:3, :3] *= 2
    made = result if vector else result[..., 0]
    return grid | {
        "values": numpy.ascontiguousarray(made, values.dtype),
        "active": there,
        "transform": matrix,
        "origin": tuple(int(i) for i in low),
    }


def _means(values, active, face, counts_empty):
    """Means over cells of eight voxels, or of four where the values lie on the lower faces of an axis."""
    weights = active.astype(numpy.float32)
    sums = numpy.where(active, values, 0)
    count = 1
    for axis in range(3):
        first, second = (tuple(slice(i, None, 2) if a == axis else slice(None) for a in range(3)) for i in (0, 1))
        if axis == face:
            sums, weights = sums[first], weights[first]
        else:
            sums, weights, count = sums[first] + sums[second], weights[first] + weights[second], 2 * count
    seen = weights > 0
    return numpy.where(seen, sums / numpy.where(counts_empty, count, numpy.maximum(weights, 1)), 0), seen


def _suits_half(values):
    largest = float(numpy.abs(values).max(initial=0))
    return largest == 0 or _LEAST_HALF <= largest <= _MOST_HALF
