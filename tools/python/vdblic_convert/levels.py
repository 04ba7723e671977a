"""Coarser copies of volumes, for viewports: each level has half the voxels of the one before along each axis."""

from vdblic._core import FramePattern, check_not_input, check_output_pattern, write_levels

from .errors import ParameterError
from .outputs import check_not_inputs, frames_of, is_whole
from .tool import whole
from .velocity import names_of

MOST_LEVELS = 8


def add_options(tool):
    tool.add("--levels", metavar=f"INT:INT in [1 - {MOST_LEVELS}]", type=whole(1, MOST_LEVELS),
             help="Write coarser copies, level 1 with voxels of twice the size and so on: lic.level1.%%04d.vdb of -o "
             "lic.%%04d.vdb; with a .usda the coarsest one is its proxy.")  # fmt: skip


class Levels:
    """The files of all levels of a sequence. @param text  pattern of the names, without the level"""

    def __init__(self, text, count, grids, skip):
        self.patterns = [FramePattern(text).of_level(level + 1) for level in range(count)]
        self._names, self._skip, self.done, self.count = names_of(grids) if grids else (), skip, 0, 0

    def check(self, frames, inputs):
        self.count = len(frames)
        for pattern in self.patterns:
            check_output_pattern(pattern, len(frames))
            check_not_inputs(map(pattern.path, frames), inputs)

    def write(self, frame, source, console):
        """Write the levels of a file; returns their paths."""
        paths = [pattern.path(frame) for pattern in self.patterns]
        self.done += 1
        for pattern, path in zip(self.patterns, paths):
            check_output_pattern(pattern, self.done)
            check_not_input(path, source)
        if not (self._skip and all(is_whole(path, console) for path in paths)):
            write_levels(str(source), list(map(str, paths)), list(self._names))
        for path in paths:
            console.finished(path)
        return paths


def export_levels(options, console, stop):
    """Write the levels of every selected frame."""
    if not options.levels:
        raise ParameterError(f"{options.output}: a .vdb would be a copy; --levels writes coarser ones")
    levels = Levels(options.output, options.levels, options.grids, options.skip_existing)
    for frame, source in frames_of(options, stop, levels.check):
        levels.write(frame, source, console)
        console.progress(frame, levels.done, levels.count)
