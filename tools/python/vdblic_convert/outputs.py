"""The outputs of a run: checked before any work, written atomically, reported when they are finished."""

import os
import zipfile

from vdblic._core import FramePattern, Sequence, check_extension, check_not_input, check_output_pattern
from vdblic._core import check_outputs, is_finished, verify

from .errors import InputError


def frames_of(options, stop, check):
    """The volumes of a sequence with their frames; `check(frames, paths)` is called first, where they are known."""
    files, found = Sequence(options.input, options.frames, options.clamp_frames, options.renumber, stop.check), False
    if options.input != "-":
        files = list(files)
        check(*zip(*files))
    for found in files:
        stop.check()
        yield found
    if not found:
        raise InputError("standard input names no files")


class Outputs:
    def __init__(self, options, extensions, console, stop):
        check_extension(options.output, extensions)
        self.pattern = FramePattern(options.output)
        self._skip, self._console, self._stop = options.skip_existing, console, stop
        self._done = self._count = 0

    def check(self, frames, inputs, count=None):
        """Check the outputs of all frames; `count` of them will be written, all unless given, 0 if that is unknown."""
        self._count = len(frames) if count is None else count
        check_outputs(self.pattern, frames)
        check_not_inputs(map(self.pattern.path, frames), inputs)

    def write(self, frame, source, write):
        """Let `write(path)` make an output, unless --skip-existing finds it whole."""
        path = self.pattern.path(frame)
        self._stop.check()
        self._done += 1
        check_output_pattern(self.pattern, self._done)
        check_not_input(path, source)
        if not (self._skip and is_whole(path, self._console)):
            write(path)
        self._console.finished(path)
        self._console.progress(frame, self._done, self._count)
        return path


def is_whole(path, console):
    """Whether an output exists and is whole, by its format without its values. Says why it is not."""
    if not is_finished(path):
        return False
    try:
        kind = path.suffix.lower()
        if kind == ".vdb":
            verify(path)
        elif kind == ".npz" and not zipfile.is_zipfile(path) or kind in (".vti", ".vtp") and not _ends(path, b"</VTKFile>"):
            raise InputError(f"{path}: ends too early")
        elif not path.stat().st_size:
            raise InputError(f"{path}: is empty")
        return True
    except InputError as error:
        console.warn(f"{error}; it is made again")
        return False


def _ends(path, end):
    with open(path, "rb") as file:
        file.seek(max(path.stat().st_size - len(end) - 2, 0))
        return file.read().rstrip().endswith(end)


def check_not_inputs(outputs, inputs):
    """Raise ParameterError if an output would replace an input."""
    taken = {_identity(path): path for path in inputs}
    for output in outputs:
        if os.path.exists(output) and _identity(output) in taken:
            check_not_input(output, taken[_identity(output)])


def _identity(path):
    status = os.stat(path)
    return status.st_dev, status.st_ino
