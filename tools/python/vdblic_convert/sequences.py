"""Frame lists and file patterns, as docs/formats.md describes them."""

import pathlib
import re
import sys

from .errors import InputError, ParameterError
from .files import check_extension, check_not_inputs, check_output, file_behind, write_file
from .tool import MOST_NUMBER

MOST_FRAMES = 1_000_000
_FIELD = re.compile(r"%(?:0(\d{1,9}))?d|(#+)|(@+)|\$F(\d{0,9})|<F(\d{0,9})>")
_NO_FIELD = re.compile(r"\*+|\?+|%\d*[diu]")


def parse_frames(text):
    """The frames of a list such as 1-100, 1-100x2 or 1,5,9-20, in order. Raises ParameterError."""
    shown, frames = text[:60], set()
    for part in text.split(","):
        match = re.fullmatch(r" *(-?\d{1,13})(?:-(-?\d{1,13})(?:x(-?\d{1,13}))?)? *", part)
        if not match or any(abs(int(number)) > MOST_NUMBER for number in match.groups() if number):
            raise ParameterError(
                f"frame list '{shown}': '{part[:60]}' is not N, N-M or N-MxSTEP, or a number is out of range"
            )
        first, last, step = int(match[1]), int(match[2] or match[1]), int(match[3] or 1)
        if last < first:
            raise ParameterError(f"frame list '{shown}': {part} runs backwards")
        if step < 1:
            raise ParameterError(f"frame list '{shown}': the step must be at least 1")
        if (last - first) // step + len(frames) >= MOST_FRAMES:
            raise ParameterError(f"frame list '{shown}': it selects more than {MOST_FRAMES} frames")
        frames.update(range(first, last + 1, step))
    return sorted(frames)


def frame_of_name(path):
    """The frame number that a file's name ends with, if there is one; the end of a date or of a time is none."""
    stem = pathlib.Path(path).stem
    digits = re.search(r"\d+$", stem)
    if not digits or len(digits[0]) > 12 or re.search(r"(\d-\d\d?-|\d:)\d\d?$", stem[-8:]):
        return None
    negative = re.search(r"(^|[._])-$", stem[: digits.start()])
    return -int(digits[0]) if negative else int(digits[0])


class Pattern:
    """A file name with at most one frame field: %04d, ####, @@@@, $F4 or <F4>."""

    def __init__(self, text):
        self.text = text
        path = pathlib.Path(text)
        self.folder, self._prefix, self._suffix, self._width = path.parent, path.name, "", None
        if len(text) > 4096 or not path.name or "\n" in text or "\0" in text:
            raise ParameterError(f"'{text[:60]!s}' is not a file name".replace("\n", " "))
        if path.exists():
            return  # an existing file of exactly this name is meant
        fields = list(_FIELD.finditer(path.name))
        if not fields:
            wrong = _NO_FIELD.search(path.name)
            if wrong:
                meant = path.name[: wrong.start()] + "%04d" + path.name[wrong.end() :]
                raise ParameterError(f"'{text}': '{wrong[0]}' is no frame field; write {self.folder / meant}")
            return
        if len(fields) > 1:
            raise ParameterError(f"'{text}' has more than one frame field; keep one")
        (field,) = fields
        self._prefix, self._suffix = path.name[: field.start()], path.name[field.end() :]
        zeros, hashes, ats, dollar, angle = field.groups()
        self._width = len(hashes or ats or "") or int(zeros or dollar or angle or 1)
        if not 1 <= self._width <= 20:
            raise ParameterError(f"'{text}': a frame field is 1 to 20 digits wide")

    @property
    def has_field(self):
        return self._width is not None

    def path(self, frame):
        return self.folder / (
            f"{self._prefix}{frame:0{self._width}d}{self._suffix}" if self.has_field else self._prefix
        )

    def companion(self, suffix):
        """A file beside the frames, with the constant part of their names: lic.pvd for lic_%04d.vti."""
        common = self._prefix.rstrip("._-") if self.has_field else pathlib.Path(self._prefix).stem
        return self.folder / f"{common or 'frames'}{suffix}"

    def frames_on_disk(self):
        """The frames whose files exist, in order. Raises InputError if there are none."""
        name = re.compile(re.escape(self._prefix) + r"(-?\d+)" + re.escape(self._suffix))
        try:
            found = [name.fullmatch(path.name) for path in self.folder.iterdir()]
        except OSError as error:
            raise InputError(f"{self.folder}: cannot read the folder: {error.strerror}") from None
        frames = [int(match[1]) for match in found if match and f"{int(match[1]):0{self._width}d}" == match[1]]
        if not frames:
            others = [match[1] for match in found if match]
            meant = (
                f"; the files on disk match {self.folder / self._prefix}%0{len(others[0])}d{self._suffix}"
                if others
                else ""
            )
            raise InputError(f"{self.text}: no file matches the pattern{meant}")
        return sorted(frames)

    def files(self):
        """The files that exist, as (frame, path) in order. Raises InputError if there are none."""
        if self.has_field:
            return [(frame, self.path(frame)) for frame in self.frames_on_disk()]
        if not self.path(1).exists():
            raise InputError(f"{self.path(1)}: no such file")
        return [(frame_of_name(self.path(1)) or 1, self.path(1))]

    def select(self, frames):
        """The files of some frames, or of every frame on disk if `frames` is None; all of them exist."""
        files = dict(self.files())
        if frames is not None and not self.has_field:
            raise ParameterError(f"'{self.text}' is one file; --frames needs a pattern such as name.%04d.vdb")
        found = list(files)
        least = min((b - a for a, b in zip(found, found[1:])), default=1)
        for frame in frames or range(found[0], found[-1] + 1, least):
            if frame not in files:
                raise InputError(f"frame {frame} is missing: {self.path(frame)}; --frames can select the others")
        return [(frame, files[frame]) for frame in frames or found]


class Outputs:
    """The outputs of a run: checked before any work, written whole, told when they are finished."""

    def __init__(self, options, extensions, console, stop):
        check_extension(options.output, extensions)
        self.pattern = Pattern(options.output)
        self._skip, self._console, self._stop = options.skip_existing, console, stop
        self._done = self._count = 0

    def check(self, frames, inputs, count):
        """Check the outputs of all frames; `count` of them will be written, 0 if that is unknown."""
        self._count = count
        if not self.pattern.has_field and len(frames) > 1:
            raise self._one_file()
        for frame in frames:
            file_behind(self.pattern.path(frame))
        check_not_inputs(map(self.pattern.path, frames), inputs)
        check_output(self.pattern.path(frames[0]))

    def write(self, frame, source, data):
        """Write the bytes that `data(path)` returns, unless the output is there and is to be left."""
        path = self.pattern.path(frame)
        self._stop.check()
        if not self.pattern.has_field and self._done:
            raise self._one_file()
        check_not_inputs([path], [source])
        if not (self._skip and path.is_file()):
            write_file(path, data(path))
        self._done += 1
        self._console.finished(path)
        self._console.progress(frame, self._done, self._count)
        return path

    def _one_file(self):
        return ParameterError(
            f"output '{self.pattern.text}' names one file but there are more frames; use a pattern such as "
            f"name.%04d{pathlib.Path(self.pattern.text).suffix}"
        )


def paths_on_standard_input(stop):
    """The paths on standard input, one a line or separated by NULs, as they come."""
    found = False
    while True:
        with stop.interruptible():
            line = sys.stdin.buffer.readline()
        if not line:
            break
        for path in line.decode(errors="surrogateescape").replace("\0", "\n").splitlines():
            if path:
                found = True
                yield path
    if not found:
        raise InputError("standard input names no files")


def numbered(path, number, taken):
    """The frame number of a path on standard input: `number`, or if it is None that of the name.

    `taken` maps the numbers so far to their paths.
    """
    frame = frame_of_name(path) if number is None else number
    if frame is None:
        raise InputError(
            f"{path}: the name does not end in a frame number; --renumber START numbers the paths as they come"
        )
    if frame in taken:
        raise InputError(
            f"{path}: frame {frame} comes twice on standard input; the first was {taken[frame]}; "
            "--renumber START numbers the paths as they come"
        )
    taken[frame] = path
    return frame
